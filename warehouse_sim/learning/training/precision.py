"""Choose the arithmetic: bf16 only where the hardware has it, because emulated bf16 is slower than fp32."""

from typing import Literal

import torch

LightningPrecision = Literal["32-true", "bf16-mixed"]


def choose_precision(wanted: Literal["auto", "32", "bf16"]) -> LightningPrecision:
    """Return Lightning's name of the arithmetic to use on this machine."""
    if wanted == "auto":
        return "bf16-mixed" if has_bf16() else "32-true"
    return "bf16-mixed" if wanted == "bf16" else "32-true"


def has_bf16() -> bool:
    """Return whether the device that Lightning will use multiplies bf16 numbers in hardware."""
    if torch.cuda.is_available():
        return torch.cuda.is_bf16_supported(including_emulation=False)
    # Torch before 2.13 does not tell; fp32 is right on every processor.
    abilities = torch.cpu.get_capabilities() if hasattr(torch.cpu, "get_capabilities") else {}
    return bool(abilities.get("avx512_bf16") or abilities.get("amx_bf16"))
