"""95 % intervals for shares, when observations of one scene resemble each other."""

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float, Int
from scipy.special import stdtrit

_Z = 1.959963984540054
"""Two-sided 95 % quantile of the normal distribution."""


def fraction_interval(
    values: Float[np.ndarray, " n"], scene_id: Int[np.ndarray, " n"], resamples: int, rng: np.random.Generator
) -> tuple[float, float]:
    """Return a 95 % interval for the mean of ``values``, the wider of two on each side.

    The bootstrap over scenes (Cameron, Gelbach and Miller 2008: resample clusters, not rows) sees that rows of one
    scene are alike, but has no width at 0 and 1 or with a single scene; Wilson's score interval has.

    Args:
        values: One number in 0-1 a row, n >= 1.
        scene_id: Scene of each row.
        resamples: Bootstrap resamples.
        rng: Source of the resamples.
    """
    _, scene = np.unique(scene_id, return_inverse=True)
    sums, counts = np.bincount(scene, weights=values), np.bincount(scene)
    return _wider_interval(_resamples(len(sums), resamples, rng), sums, counts, float(values.mean()))


def _resamples(scenes: int, resamples: int, rng: np.random.Generator) -> Int[np.ndarray, "r s"]:
    """Return how often each scene is drawn in each resample."""
    return rng.multinomial(scenes, np.full(scenes, 1.0 / scenes), size=resamples)


def _wider_interval(picks: np.ndarray, sums: np.ndarray, counts: np.ndarray, mean: float) -> tuple[float, float]:
    """Return the percentiles over resamples of scenes, or the ends of Wilson's interval where those lie outside."""
    low, high = np.percentile((picks @ sums) / (picks @ counts), [2.5, 97.5])
    wilson_low, wilson_high = wilson(mean, int(counts.sum()))
    return min(float(low), wilson_low), max(float(high), wilson_high)


def fraction_intervals(
    columns: Mapping[str, Float[np.ndarray, " n"]], scene_id: Int[np.ndarray, " n"], resamples: int, seed: int
) -> dict[str, tuple[float, float]]:
    """Return ``fraction_interval`` of several columns over the same rows, all with the same resamples.

    A new column moves no other one's interval, nor does it draw again: of large tables, the resamples take longest.

    Args:
        columns: By name; nan where a row has no such value. Columns without any value are left out.
        scene_id: Scene of each row.
        resamples: Bootstrap resamples.
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
            picks[there.tobytes()] = _resamples(int(there.sum()), resamples, np.random.default_rng(seed))
        sums = np.bincount(scene[known], weights=values[known], minlength=len(names))
        mean = float(values[known].mean())
        intervals[name] = _wider_interval(picks[there.tobytes()], sums[there], counts[there], mean)
    return intervals


def wilson(fraction: float, count: int) -> tuple[float, float]:
    """Return Wilson's score interval (J. Am. Stat. Assoc. 22, 1927) of a fraction among ``count`` rows."""
    centre = (fraction + _Z**2 / (2 * count)) / (1 + _Z**2 / count)
    half = _Z / (1 + _Z**2 / count) * np.sqrt(fraction * (1 - fraction) / count + _Z**2 / (4 * count**2))
    return max(0.0, float(centre - half)), min(1.0, float(centre + half))


def seed_interval(values: Sequence[float]) -> tuple[float, float]:
    """Return Student's 95 % interval for the mean over trainings with other seeds.

    With three of them it is 4.3 standard errors wide on each side (2 degrees of freedom), with eight 2.4; resampling
    three values, as a bootstrap does, would make it less than half of that.
    """
    mean, count = float(np.mean(values)), len(values)
    if count < 2:
        return -1.0, 1.0  # one training tells nothing: shares and their differences lie between these
    half = float(stdtrit(count - 1, 0.975)) * float(np.std(values, ddof=1)) / np.sqrt(count)
    return mean - half, mean + half


def difference_interval(values: Float[np.ndarray, " n"], scene_id: Int[np.ndarray, " n"]) -> tuple[float, float]:
    """Return a 95 % interval for the mean of paired differences in -1 ... 1, by Student over scenes.

    The variance of a ratio of sums over scenes, linearised (Cochran 1977, 6.3), with as many degrees of freedom as
    there are scenes but one: where a bootstrap of three scenes says too little. Where no two scenes differ, it is
    Wilson's interval for the fraction of pairs that would have changed, both ways; one scene tells nothing.

    Args:
        values: One difference a pair, n >= 1.
        scene_id: Scene of each pair.
    """
    _, scene = np.unique(scene_id, return_inverse=True)
    sums, counts = np.bincount(scene, weights=values), np.bincount(scene)
    mean, scenes = float(sums.sum() / counts.sum()), len(sums)
    if scenes < 2:
        return -1.0, 1.0
    off = (sums - mean * counts) / counts.mean()
    half = float(stdtrit(scenes - 1, 0.975) * np.sqrt((off**2).sum() / (scenes * (scenes - 1))))
    if half == 0.0:
        half = wilson(0.0, len(values))[1]
    return max(mean - half, -1.0), min(mean + half, 1.0)
