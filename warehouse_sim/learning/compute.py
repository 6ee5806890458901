"""Where and how networks compute: device, arithmetic, threads, or not at all but for their shapes."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Literal

import torch
from torch import Tensor, nn
from torch.nn.utils.fusion import fuse_conv_bn_eval
from torch.overrides import TorchFunctionMode

from warehouse_sim.errors import InputError


def on_device(values: Tensor, device: torch.device) -> Tensor:
    """Return a tensor of the CPU on ``device``; a GPU is not waited for."""
    if device.type != "cuda" or not values.numel():
        return values.to(device)
    # From memory that stays where it is, a GPU copies when its turn comes.
    return values.pin_memory().to(device, non_blocking=True)


def chosen_device(wanted: Literal["auto", "cpu", "cuda"]) -> torch.device:
    """Return where to compute; ``auto`` takes a GPU if there is one.

    Raises:
        InputError: A GPU is requested, and torch finds none.
    """
    has_gpu = torch.cuda.is_available()
    if wanted == "cuda" and not has_gpu:
        raise InputError("device cuda: PyTorch finds no GPU on this machine; choose auto or cpu")
    return torch.device(("cuda" if has_gpu else "cpu") if wanted == "auto" else wanted)


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


SMALL = 3_000_000
"""Networks of fewer weights run on one thread."""


def place(
    network: nn.Module, device: Literal["auto", "cpu", "cuda"], threads: int | None
) -> tuple[torch.device, int | None]:
    """Move a network to where it predicts, and return that and its CPU threads; None for torch's own number.

    Args:
        network: Ready for inference; its normalisations become part of the convolutions before them.
        device: "auto" takes a GPU if there is one.
        threads: As they are requested; None takes one for small networks.

    Raises:
        InputError: A GPU is requested, and torch finds none.
    """
    chosen = chosen_device(device)
    small = sum(parameter.numel() for parameter in network.parameters()) < SMALL
    fold_normalisations(network)
    # Convolutions of CPUs and GPUs read the channels of a pixel together.
    network.to(chosen, memory_format=torch.channels_last)  # type: ignore[call-overload]  # not in torch's stubs
    return chosen, threads or (1 if small else None)


def fold_normalisations(network: nn.Module) -> None:
    """Make every batch normalisation that follows a convolution in a sequence part of it; what is computed stays.

    Args:
        network: Ready for inference: a normalisation with running means.
    """
    for part in network.modules():
        # What computes in its own way may need both.
        if not isinstance(part, nn.Sequential) or type(part).forward is not nn.Sequential.forward:
            continue
        for number, (layer, after) in enumerate(zip(list(part), list(part)[1:], strict=False)):
            if isinstance(layer, nn.Conv2d) and isinstance(after, nn.BatchNorm2d):
                part[number], part[number + 1] = fuse_conv_bn_eval(layer, after), nn.Identity()


@contextmanager
def cpu_threads(wanted: int | None) -> Iterator[None]:
    """Use so many CPU threads in this process during the block; None leaves torch its own number."""
    before = torch.get_num_threads()
    if wanted:
        torch.set_num_threads(wanted)
    try:
        yield
    finally:
        torch.set_num_threads(before)


class _Unsampled(TorchFunctionMode):
    """Leave tensors without the first values that they would be given."""

    def __torch_function__(
        self, func: Callable[..., Any], types: Any, args: tuple[Any, ...] = (), kwargs: dict[str, Any] | None = None
    ) -> Any:
        """Return unfilled what ``torch.nn.init`` or ``torch.eye`` would fill; call any other function."""
        given = kwargs or {}
        if getattr(func, "__module__", None) == torch.nn.init.__name__:
            return given["tensor"] if "tensor" in given else args[0]
        if func is torch.eye and not given:
            return torch.empty(args[0], args[-1])
        return func(*args, **given)


@contextmanager
def shapes_only() -> Iterator[None]:
    """Make every tensor on the device ``meta``, where it has a shape and no values.

    Normal values and unit matrices would be made there, too, of no use, by code that imports PyTorch's compiler, which
    takes seconds.
    """
    with torch.device("meta"), _Unsampled():
        yield
