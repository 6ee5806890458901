"""Shares and differences of the paired question."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from benchmarks.estimators import over_seeds, paired
from warehouse_sim.generation.recipe import load_recipe

SCENES = np.repeat(np.arange(6), 5)


def scores(passes: list[int]) -> Any:
    """Return the scores of 30 objects in six scenes, of which ``passes`` pass; none can be docked."""
    values = np.isin(np.arange(30), passes).astype(float)
    metrics = {"add_5pct": values, "add_10pct": values, "dock_0mm": np.full(30, np.nan)}
    return SimpleNamespace(table=SimpleNamespace(scene_id=SCENES, values=metrics))


@pytest.fixture
def found(monkeypatch: pytest.MonkeyPatch) -> paired.Found:
    """Two seeds: 10 and 14 of 30 for whoever is scored on what it was trained on, else 7 and 5; 20 of 30 for both."""
    monkeypatch.setattr(over_seeds, "pass_values", lambda table, config: table.values)
    own, other, both = ([10, 14], [7, 5], [20, 20])
    sets = ("raster", "pathtrace")
    counts = {(a, b): own if a == b else other for a in sets for b in sets} | {("both", b): both for b in sets}
    return {key: [scores(list(range(count))) for count in seeds] for key, seeds in counts.items()}


def test_shares_are_means_over_seeds_and_leave_out_what_applies_to_nothing(found: paired.Found) -> None:
    rows = {row["name"]: row for row in paired.fractions(found)}
    assert len(rows) == 6 * 2
    row = rows["trained on raster, scored on pathtrace: add_5pct"]
    assert row["value"] == pytest.approx(6 / 30, rel=1e-3)
    assert row["seeds"] == pytest.approx([7 / 30, 5 / 30], rel=1e-3)
    assert row["n"] == 30
    assert row["interval"][0] < 6 / 30 < row["interval"][1]


def test_differences_are_of_the_first_training_over_the_second(found: paired.Found) -> None:
    answers = {(row["question"], row["metric"]): row for row in paired.differences(found)}
    assert len(answers) == 4 * 2
    expected = [(12 - 6) / 30, (12 - 6) / 30, (20 - 6) / 30, (20 - 6) / 30]
    for (question, *_), value in zip(paired.QUESTIONS, expected, strict=True):
        row = answers[question, "add_5pct"]
        assert row["difference"] == pytest.approx(value, rel=1e-3)
        low, high = row["difference_interval"]
        assert low < value < high


def test_the_small_recipe_has_scenes_for_every_split() -> None:
    from warehouse_sim.dataset.split import split_scenes

    recipe = load_recipe(str(paired.SMALL))
    splits = split_scenes(recipe.scenes, recipe.split)
    assert {name: len(indices) for name, indices in splits.items()} == {"train": 8, "val": 2, "test": 6}
