import numpy as np
import pytest

from warehouse_sim.dataset.split import SPLITS, SplitConfig, split_scenes
from warehouse_sim.errors import ConfigError, DatasetError


@pytest.mark.parametrize("fractions", [(0.7, 0.1, 0.2), (0.34, 0.33, 0.33), (0.98, 0.01, 0.01), (0.5, 0.0, 0.5)])
def test_splits_are_contiguous_disjoint_and_complete(fractions: tuple[float, float, float]) -> None:
    config = SplitConfig(*fractions)
    for scene_count in (*range(1, 40), 250):
        splits = split_scenes(scene_count, config)
        assert [index for name in ("train", "val", "test") for index in splits[name]] == list(range(scene_count))
        if scene_count >= 3:
            assert all(splits[name] for name, fraction in zip(SPLITS, fractions, strict=True) if fraction > 0)
        for name, fraction in zip(SPLITS, fractions, strict=True):
            assert abs(len(splits[name]) - fraction * scene_count) < 2.0, scene_count


@pytest.mark.parametrize(
    ("scene_count", "sizes"), [(1, (1, 0, 0)), (2, (1, 0, 1)), (3, (1, 1, 1)), (10, (7, 1, 2)), (100, (70, 10, 20))]
)
def test_sizes_of_the_default_split(scene_count: int, sizes: tuple[int, int, int]) -> None:
    splits = split_scenes(scene_count, SplitConfig())
    assert tuple(len(splits[name]) for name in SPLITS) == sizes


def test_a_share_of_zero_gives_an_empty_split() -> None:
    assert split_scenes(5, SplitConfig(0.0, 0.0, 1.0)) == {"train": (), "val": (), "test": (0, 1, 2, 3, 4)}


def test_no_scene_is_an_error() -> None:
    with pytest.raises(DatasetError, match="needs at least one scene, found 0"):
        split_scenes(0, SplitConfig())


@pytest.mark.parametrize("fractions", [(0.7, 0.1, 0.1), (0.0, 0.0, 0.0)])
def test_shares_must_sum_to_one(fractions: tuple[float, float, float]) -> None:
    with pytest.raises(ConfigError, match="sum to 1"):
        SplitConfig(*fractions)


def test_stratified_splits_are_alike_where_contiguous_ones_are_not() -> None:
    rng = np.random.default_rng(5)
    # The first scenes are near and dark, the last ones far and bright: the worst case for contiguous splits.
    rising = np.linspace(0.0, 1.0, 60)
    features = np.stack([rising, rng.permutation(rising), rising[::-1] ** 2], axis=1)
    contiguous, stratified = split_scenes(60, SplitConfig()), split_scenes(60, SplitConfig(), features)
    assert {name: len(found) for name, found in stratified.items()} == {
        name: len(found) for name, found in contiguous.items()
    }
    assert sorted(index for found in stratified.values() for index in found) == list(range(60))
    worst = {
        kind: max(
            abs(features[list(splits[a])].mean(axis=0) - features[list(splits["train"])].mean(axis=0)).max()
            for a in ("val", "test")
        )
        for kind, splits in (("contiguous", contiguous), ("stratified", stratified))
    }
    assert worst["stratified"] < 0.15 < 0.4 < worst["contiguous"]


def test_a_stratified_split_of_few_scenes_still_gives_every_split_one() -> None:
    splits = split_scenes(3, SplitConfig(), np.array([[0.1], [0.9], [0.5]]))
    assert sorted(len(found) for found in splits.values()) == [1, 1, 1]
