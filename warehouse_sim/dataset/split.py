"""Train, validation and test are split by scene, never by image."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from warehouse_sim.errors import DatasetError

Split = Literal["train", "val", "test"]
SPLITS: tuple[Split, ...] = ("train", "val", "test")
# Who gets a scene first when there are fewer scenes than splits.
_PRIORITY: tuple[Split, ...] = ("train", "test", "val")


@dataclass(frozen=True)
class SplitConfig:
    """Shares of the scenes; the three must sum to 1."""

    train: float = 0.7
    """Share of the scenes to learn from, 0 to 1."""
    val: float = 0.1
    """Share of the scenes to choose checkpoints and settings on, 0 to 1."""
    test: float = 0.2
    """Share of the scenes to score on, 0 to 1."""

    def __post_init__(self) -> None:
        shares = (self.train, self.val, self.test)
        if min(shares) < 0 or abs(sum(shares) - 1.0) > 1e-6:
            raise ValueError(f"train, val and test must be >= 0 and sum to 1, found {shares}")


def split_scenes(scene_count: int, config: SplitConfig) -> dict[Split, tuple[int, ...]]:
    """Return the scene indices of every split: train first, then val, then test, each contiguous.

    Every split with a share above zero gets at least one scene; with fewer scenes than such splits, train comes
    first, then test, then val.

    Raises:
        DatasetError: There is no scene to split.
    """
    if scene_count < 1:
        raise DatasetError(f"a dataset needs at least one scene, found {scene_count}; ask for more with --scenes")
    shares = {name: getattr(config, name) for name in SPLITS}
    wanted = [name for name in _PRIORITY if shares[name] > 0]
    counts = dict.fromkeys(SPLITS, 0)
    for name in wanted[:scene_count]:
        counts[name] = 1
    while sum(counts.values()) < scene_count:
        # The split that is furthest below its share takes the next scene; ties go by priority.
        neediest = max(wanted, key=lambda name: round(shares[name] * scene_count - counts[name], 9))
        counts[neediest] += 1
    ends = np.cumsum([counts[name] for name in SPLITS])
    return {name: tuple(range(int(end) - counts[name], int(end))) for name, end in zip(SPLITS, ends, strict=True)}
