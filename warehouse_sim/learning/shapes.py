"""Networks of shapes alone, to count weights or compare their layout: without memory, and without drawing a weight."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import torch
from torch.overrides import TorchFunctionMode


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
