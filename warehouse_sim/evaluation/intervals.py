"""95 % intervals for shares, when observations of one scene resemble each other."""

from collections.abc import Mapping

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
    return _percentiles(picks, sums, counts)


def _percentiles(picks: np.ndarray, sums: np.ndarray, counts: np.ndarray) -> tuple[float, float]:
    low, high = np.percentile((picks @ sums) / (picks @ counts), [2.5, 97.5])
    return float(low), float(high)


def share_intervals(
    columns: Mapping[str, Float[np.ndarray, " n"]], scene_id: Int[np.ndarray, " n"], draws: int, seed: int
) -> dict[str, tuple[float, float]]:
    """Return ``share_interval`` of several columns over the same rows, all with the same resamples.

    A new column moves no other one's interval, nor does it draw anew: of large tables, the draws take longest.

    Args:
        columns: By name; nan where a row has no such value. Columns without any value are left out.
        scene_id: Scene of each row.
        draws: Bootstrap resamples.
        seed: Of the resamples.
    """
    names, scene = np.unique(scene_id, return_inverse=True)
    picks: dict[bytes, np.ndarray] = {}
    intervals = {}
    for name, values in columns.items():
        known = ~np.isnan(values)
        if not known.any():
            continue
        counts = np.bincount(scene[known], minlength=len(names))
        there = counts > 0
        if there.tobytes() not in picks:
            share = np.full(int(there.sum()), 1.0 / there.sum())
            picks[there.tobytes()] = np.random.default_rng(seed).multinomial(len(share), share, size=draws)
        sums = np.bincount(scene[known], weights=values[known], minlength=len(names))
        low, high = _percentiles(picks[there.tobytes()], sums[there], counts[there])
        wilson_low, wilson_high = wilson(float(values[known].mean()), int(known.sum()))
        intervals[name] = min(low, wilson_low), max(high, wilson_high)
    return intervals


def wilson(share: float, count: int) -> tuple[float, float]:
    """Return Wilson's score interval (J. Am. Stat. Assoc. 22, 1927) of a share among ``count`` rows."""
    centre = (share + _Z**2 / (2 * count)) / (1 + _Z**2 / count)
    half = _Z / (1 + _Z**2 / count) * np.sqrt(share * (1 - share) / count + _Z**2 / (4 * count**2))
    return max(0.0, float(centre - half)), min(1.0, float(centre + half))
