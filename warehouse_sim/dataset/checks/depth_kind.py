"""Whether depth is along the optical axis, as everywhere here, or the distance to the camera."""

import numpy as np
from jaxtyping import Float

_FEW = 200
_AGREES = 0.05
_LEAST_SPREAD = 0.02
"""Of distance over depth within the image: a narrow view cannot tell one from the other."""


def range_fraction(
    read: Float[np.ndarray, " n"], z: Float[np.ndarray, " n"], distance: Float[np.ndarray, " n"]
) -> float:
    """Return how much of the way from z-depth to distance the readings went: 0 = depth along the axis, 1 = range.

    Least squares of ``read = a z + b (distance - z)`` on what agrees with either; ``a`` takes a sensor's scale.

    Args:
        read: Depth as stored (m).
        z: True depth along the axis (m).
        distance: True distance (m).
    """
    near = np.minimum(np.abs(read - z), np.abs(read - distance)) < _AGREES * z
    ahead = distance[near] / z[near] - 1.0
    if len(ahead) < _FEW or np.ptp(ahead) < _LEAST_SPREAD:
        return 0.0
    (_, fraction), *_ = np.linalg.lstsq(
        np.stack([np.ones_like(ahead), ahead], axis=1), read[near] / z[near], rcond=None
    )
    return float(fraction)
