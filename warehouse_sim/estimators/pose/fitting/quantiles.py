"""Quantiles at either end of many short rows: numpy's own spend most of their time on what these do not need."""

import numpy as np
from jaxtyping import Float


def quantiles(
    values: Float[np.ndarray, "*batch n"], fraction: float
) -> tuple[Float[np.ndarray, "*batch"], Float[np.ndarray, "*batch"]]:
    """Return the quantiles ``fraction`` and ``1 - fraction`` of the last axis, linear as numpy's default.

    Args:
        values: At least one a row.
        fraction: 0-0.5.
    """
    ordered = np.sort(values, axis=-1)
    last = ordered.shape[-1] - 1
    low = int(fraction * last)
    part = fraction * last - low
    high, inner = last - low, min(low + 1, last)
    return (
        ordered[..., low] + part * (ordered[..., inner] - ordered[..., low]),
        ordered[..., high] + part * (ordered[..., last - inner] - ordered[..., high]),
    )
