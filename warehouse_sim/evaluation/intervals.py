"""95 % intervals for shares, when observations of one scene resemble each other."""

import numpy as np
from jaxtyping import Float, Int

_Z = 1.959963984540054
"""Two-sided 95 % quantile of the normal distribution."""


def share_interval(
    values: Float[np.ndarray, " n"], scene_id: Int[np.ndarray, " n"], draws: int, rng: np.random.Generator
) -> tuple[float, float]:
    """Return a 95 % interval for the mean of ``values``, the wider of two on each side.

    The bootstrap over scenes (Cameron, Gelbach and Miller 2008: resample clusters, not rows) sees that rows of one
    scene are alike, but has no width at 0 and 1 or with a single scene; Wilson's score interval has.

    Args:
        values: One number in 0-1 a row, n >= 1.
        scene_id: Scene of each row.
        draws: Bootstrap resamples.
        rng: Source of the resamples.
    """
    boot_low, boot_high = scene_bootstrap(values, scene_id, draws, rng)
    wilson_low, wilson_high = wilson(float(values.mean()), len(values))
    return min(boot_low, wilson_low), max(boot_high, wilson_high)


def scene_bootstrap(
    values: Float[np.ndarray, " n"], scene_id: Int[np.ndarray, " n"], draws: int, rng: np.random.Generator
) -> tuple[float, float]:
    """Return the percentile interval of the mean under resampling of whole scenes."""
    _, scene = np.unique(scene_id, return_inverse=True)
    sums, counts = np.bincount(scene, weights=values), np.bincount(scene)
    picks = rng.multinomial(len(sums), np.full(len(sums), 1.0 / len(sums)), size=draws)
    low, high = np.percentile((picks @ sums) / (picks @ counts), [2.5, 97.5])
    return float(low), float(high)


def wilson(share: float, count: int) -> tuple[float, float]:
    """Return Wilson's score interval (J. Am. Stat. Assoc. 22, 1927) of a share among ``count`` rows."""
    centre = (share + _Z**2 / (2 * count)) / (1 + _Z**2 / count)
    half = _Z / (1 + _Z**2 / count) * np.sqrt(share * (1 - share) / count + _Z**2 / (4 * count**2))
    return max(0.0, float(centre - half)), min(1.0, float(centre + half))
