"""Choose the arithmetic: bf16 only where the hardware has it, because emulated bf16 is slower than fp32."""

from typing import Literal

import torch

Precision = Literal["32-true", "bf16-mixed"]


def choose_precision(wanted: Literal["auto", "32", "bf16"]) -> Precision:
    """Return the arithmetic to use on this machine."""
    if wanted == "auto":
        return "bf16-mixed" if has_bf16() else "32-true"
    return "bf16-mixed" if wanted == "bf16" else "32-true"


def mixed(precision: Precision, device: torch.device) -> torch.autocast:
    """Return the context in which a network computes; bf16 has the range of fp32, so that no loss is scaled."""
    return torch.autocast(device.type, dtype=torch.bfloat16, enabled=precision == "bf16-mixed")


def has_bf16() -> bool:
    """Return whether the device that trains multiplies bf16 numbers in hardware."""
    if torch.cuda.is_available():
        return torch.cuda.is_bf16_supported(including_emulation=False)
    # Torch before 2.13 does not tell; fp32 is right on every processor.
    abilities = torch.cpu.get_capabilities() if hasattr(torch.cpu, "get_capabilities") else {}
    return bool(abilities.get("avx512_bf16") or abilities.get("amx_bf16"))
