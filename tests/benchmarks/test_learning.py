"""Comparisons of trainings: of losses, of refiners, of starts on another sensor."""

from dataclasses import dataclass, fields
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from benchmarks.estimators import losses, over_seeds, refiner, transfer, upon
from benchmarks.estimators.data import ROBUST, SCORED
from warehouse_sim.estimators.pose.densefusion.run_config import read_config
from warehouse_sim.estimators.pose.densefusion.settings import LossConfig
from warehouse_sim.resources import data_folder


@dataclass
class Table:
    """As many objects as there are errors, ten a scene."""

    add: np.ndarray
    score: np.ndarray
    found: np.ndarray
    surface_rms: np.ndarray
    error_bound: np.ndarray
    scene_id: np.ndarray
    distance: np.ndarray
    diameter: np.ndarray
    dockable: np.ndarray

    def select(self, chosen: np.ndarray) -> "Table":
        return Table(*(getattr(self, item.name)[chosen] for item in fields(self)))

    def docks(self) -> np.ndarray:
        return self.add < 0.05


def made_scores(add: np.ndarray, score: np.ndarray | None = None) -> Any:
    """Scores of objects of 1 m; the bound is always 4 cm."""
    ones = np.ones(len(add))
    table = Table(
        add,
        ones * 0.5 if score is None else score,
        ones > 0,
        add,
        ones * 0.04,
        np.arange(len(add)) // 10,
        ones * 3.0,
        ones,
        ones > 0,
    )
    fraction = float((add < 0.05).mean())
    return SimpleNamespace(table=table, overall=SimpleNamespace(metrics={"add_5pct": fraction, "dock_0mm": fraction}))


@pytest.fixture(autouse=True)
def metrics(monkeypatch: pytest.MonkeyPatch) -> None:
    def values(table: Table, _: Any) -> dict[str, np.ndarray]:
        limits = {"add_10pct": 0.1, "add_5pct": 0.05, "add_2pct": 0.02, "dock_0mm": 0.05}
        return {name: (table.add < limit).astype(float) for name, limit in limits.items()}

    monkeypatch.setattr(over_seeds, "pass_values", values)


def test_the_losses_are_what_their_names_say() -> None:
    assert losses.LOSSES["rms"] == LossConfig()
    assert len(set(losses.LOSSES.values())) == len(losses.LOSSES) == len(losses.TITLES)
    theirs = losses.LOSSES["dissertation"]
    assert (theirs.distance, theirs.unit, theirs.confidence_weight) == ("chamfer-squared", "metres", 0.015)


def test_confidence_is_measured_by_rank_certainty_and_bound() -> None:
    add = np.array([0.01, 0.02, 0.03, 0.06, 0.07])
    found = made_scores(add, np.array([0.995, 0.9, 0.4, 0.5, 0.1]))
    # Of the six pairs of a right and a wrong one, one is the wrong way round.
    assert losses.value_of(found, "auroc") == pytest.approx(5 / 6)
    assert losses.value_of(found, "sure") == 0.2
    assert losses.value_of(found, "bound") == 0.6
    rows = losses.measured("rms", [found, made_scores(add + 1.0)])
    # The second has nothing right, so that nobody can say how it ranks.
    assert next(row for row in rows if row["measure"] == "auroc")["seeds"] == [pytest.approx(0.83333)]
    nothing = losses.measured("rms", [made_scores(add + 1.0)])
    assert "auroc" not in {row["measure"] for row in nothing}
    assert "| - |" in losses.as_markdown(nothing, [])


def test_a_refiner_is_compared_with_none_object_by_object() -> None:
    before = np.tile([0.04, 0.06], 20)
    scores = {setting.name: made_scores(before) for setting in refiner.settings((0, 1, 2))}
    scores["consensus 2"] = made_scores(before - 0.02)
    rows = {row["name"]: row for row in refiner.rows("net", scores, (1, 2))}
    row = rows["net, consensus, 2 corrections: dock_0mm_2_7m"]
    assert (row["value"], row["without"], row["difference"], row["n"]) == (1.0, 0.5, 0.5, 40)
    assert row["difference_interval"] == [0.5, 0.5]
    assert rows["net, consensus, 1 corrections: add_5pct"]["difference"] == 0.0
    assert rows["net, consensus + ICP, 2 corrections: add_5pct"]["difference"] == 0.0


def test_a_transfer_is_compared_with_the_start_and_with_fresh_weights() -> None:
    def everywhere(add: np.ndarray) -> dict[str, Any]:
        return {setting.name: made_scores(add) for setting in transfer.SETTINGS}

    half, all_right, none = np.tile([0.04, 0.06], 20), np.full(40, 0.01), np.full(40, 0.5)
    found = {
        ("as it was", 0): [everywhere(half)],
        ("trained on", 50): [everywhere(all_right), everywhere(half)],
        ("fresh", 50): [everywhere(none), everywhere(none)],
    }
    rows = {row["name"]: row for row in transfer.gains(found, 50)}
    over_start = rows["50 images against as it was, consensus: dock_2_7m"]
    assert over_start["difference"] == 0.25
    assert over_start["difference_interval"] == pytest.approx(over_seeds.seed_interval([0.5, 0.0]))
    assert rows["50 images against fresh, consensus + ICP: add_5pct"]["difference"] == 0.75
    fractions = transfer.rows_of("trained on", 50, found["trained on", 50])
    assert fractions[0]["seeds"] == [1.0, 0.5]
    low, high = fractions[0]["interval"]
    assert low <= fractions[0]["value"] == 0.75 <= high
    assert "| 50 images against fresh |" in transfer.as_markdown([*fractions, *rows.values()])


def test_what_has_seen_the_other_sensor_is_no_start(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def knows(*names: str) -> None:
        seen = SimpleNamespace(datasets=[SimpleNamespace(name=name) for name in names])
        monkeypatch.setattr(transfer, "read_config", lambda _: seen)

    monkeypatch.setattr(transfer, "made_data", lambda data, folder: tmp_path)
    monkeypatch.setattr(transfer, "settings_upon", lambda *_: transfer.TrainConfig())
    requested: list[tuple] = []
    monkeypatch.setattr(transfer, "train", lambda *how, **more: requested.append(how))
    knows(SCORED[0].folder_name, SCORED[1].folder_name)
    assert transfer.source_of("densefusion-depth", tmp_path, 5, None) == "densefusion-depth"
    knows(SCORED[0].folder_name, ROBUST[0].folder_name)
    assert transfer.source_of("densefusion-depth", tmp_path, 5, None).endswith("densefusion-depth_kitti_5")
    assert len(requested) == 1


def test_training_upon_a_model_keeps_its_inputs_and_leaves_out_what_it_does_not_know(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    model = data_folder("models") / "densefusion-pointcloud"
    config = read_config(model)
    names = [config.objects[0].name, "sampled_pallet_7"]
    reader = SimpleNamespace(objects={k: SimpleNamespace(name=name) for k, name in enumerate(names)})
    monkeypatch.setattr(upon, "DatasetReader", lambda folder: reader)
    found = upon.settings_upon(model, [Path("one")], phase="refiner", refiner_iterations=2)
    assert (found.objects, found.phase) == ((config.objects[0].name,), "refiner")
    assert (found.size, found.surroundings, found.augment) == (
        config.train.size,
        config.train.surroundings,
        config.train.augment,
    )
    reader.objects.pop(1)
    assert upon.settings_upon(model, [Path("one")]).objects == ()
