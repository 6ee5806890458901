"""Train, validation and test are split by scene, never by image; on request so that they are alike."""

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from jaxtyping import Float, Int

from warehouse_sim.errors import DatasetError, shown, suggestion
from warehouse_sim.ranges import Fraction, ranged

Split = Literal["train", "val", "test"]
SPLITS: tuple[Split, ...] = ("train", "val", "test")
# Who gets a scene first when there are fewer scenes than splits.
_PRIORITY: tuple[Split, ...] = ("train", "test", "val")


def require_split(root: Path, name: str, known: Iterable[str]) -> None:
    """Check that a dataset has a split.

    Raises:
        DatasetError: It has not; names those that there are.
    """
    there = list(known)
    if name not in there:
        hint = suggestion(name, there)
        raise DatasetError(f"{root}: there is no split {shown(name)}{hint}; known: {', '.join(there)}")


def parts_of(splits: Collection[str]) -> tuple[str, ...]:
    """Return the splits without KITTI's "trainval" where train and val are there, which it is the union of."""
    union = {"train", "val", "trainval"} <= set(splits)
    return tuple(name for name in splits if not (union and name == "trainval"))


@dataclass(frozen=True)
@ranged
class SplitConfig:
    """Fractions of the scenes; the three must sum to 1."""

    train: Fraction = 0.7
    """Fraction of the scenes to learn from, 0-1."""
    val: Fraction = 0.1
    """Fraction of the scenes to choose checkpoints and settings on, 0-1."""
    test: Fraction = 0.2
    """Fraction of the scenes to score on, 0-1."""
    stratify: tuple[Literal["visible_fraction", "distance", "lux"], ...] = ()
    """Measured means of a scene's targets in which the splits shall be alike; none = split by index."""

    def __post_init__(self) -> None:
        fractions = (self.train, self.val, self.test)
        if abs(sum(fractions) - 1.0) > 1e-6:
            raise ValueError(f"train, val and test must sum to 1, found {fractions}")


def split_scenes(
    scene_count: int, config: SplitConfig, features: Float[np.ndarray, "n k"] | None = None
) -> dict[str, tuple[int, ...]]:
    """Return the scene indices of every split, ascending.

    Every split with a fraction above zero gets at least one scene; with fewer scenes than such splits, train comes
    first, then test, then val. Without features the splits are contiguous: train first, then val, then test.

    Args:
        scene_count: Number of scenes.
        config: Shares.
        features: What the splits shall be alike in, one row a scene: scenes are put in serpentine order of their
            features and dealt out along it, each to the split that is furthest below its fraction (systematic sampling,
            Chromy 1979).

    Raises:
        DatasetError: There is no scene to split.
    """
    if scene_count < 1:
        raise DatasetError(f"a dataset needs at least one scene, found {scene_count}; request more with --scenes")
    counts = _counts(scene_count, config)
    if features is None:
        ends = np.cumsum([counts[name] for name in SPLITS])
        return {name: tuple(range(int(end) - counts[name], int(end))) for name, end in zip(SPLITS, ends, strict=True)}
    dealt: dict[Split, list[int]] = {name: [] for name in SPLITS}
    open_splits = [name for name in _PRIORITY if counts[name] > 0]
    for place, index in enumerate(_serpentine(features), start=1):
        fraction = {name: counts[name] * place / scene_count - len(dealt[name]) for name in open_splits}
        dealt[max(open_splits, key=lambda name: round(fraction[name], 9))].append(int(index))
    return {name: tuple(sorted(indices)) for name, indices in dealt.items()}


def _counts(scene_count: int, config: SplitConfig) -> dict[Split, int]:
    fractions = {name: getattr(config, name) for name in SPLITS}
    wanted = [name for name in _PRIORITY if fractions[name] > 0]
    counts: dict[Split, int] = dict.fromkeys(SPLITS, 0)
    for name in wanted[:scene_count]:
        counts[name] = 1
    while sum(counts.values()) < scene_count:
        # The split that is furthest below its fraction takes the next scene; ties go by priority.
        neediest = max(wanted, key=lambda name: round(fractions[name] * scene_count - counts[name], 9))
        counts[neediest] += 1
    return counts


def _serpentine(features: Float[np.ndarray, "n k"]) -> Int[np.ndarray, " n"]:
    """Return the order in which the first feature rises block by block, and each next one up and down in turn."""
    count, width = features.shape
    if width == 0 or count < 2:
        return np.arange(count)
    order = np.argsort(features[:, 0], kind="stable")
    if width == 1:
        return order
    blocks = np.array_split(order, round(count ** (1.0 / width)))
    inner = [block[_serpentine(features[block, 1:])] for block in blocks]
    return np.concatenate([block[::-1] if number % 2 else block for number, block in enumerate(inner)])
