"""Questions of predictions for a dataset; how often simulation and swept-volume check agree on planted errors."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from jaxtyping import Bool

from tests.benchmark.docking.planted import KINDS, questions
from tests.evaluation.made_dataset import estimates_of, write_estimates
from tests.stored import held
from warehouse_sim.annotate.dockable import accessibility
from warehouse_sim.annotate.trucks import TRUCKS
from warehouse_sim.benchmark.docking.record import Kept, answer, simulated_docks, swept_docks, truck_verdicts
from warehouse_sim.dataset.split import SplitConfig
from warehouse_sim.dataset.stored.scene_record import read_scene_record
from warehouse_sim.evaluation.intervals import fraction_interval
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import sample_settled_scene
from warehouse_sim.geometry.pose import make_transform


def test_a_recipe_asks_every_kind_of_the_sides_that_a_truck_reaches() -> None:
    evaluated = list(questions("smoke", 2 * len(KINDS), seed=1))
    assert [question.kind for question, _ in evaluated] == [*KINDS, *KINDS]
    assert len({(question.scene, question.instance, question.face) for question, _ in evaluated}) == 2
    reach = {}
    for index in {question.scene for question, _ in evaluated}:
        sampled = sample_settled_scene(load_recipe("smoke"), 1, index)
        reach[index] = accessibility(sampled.scene, TRUCKS[sampled.settings.layout.truck])
    for question, station in evaluated:
        assert reach[question.scene][question.instance].faces[question.face] in ("free", "under a stack")
        assert station.pallet.instance_id == question.instance
    again = list(questions("smoke", 2 * len(KINDS), seed=1))
    for (one, _), (other, _) in zip(evaluated, again, strict=True):
        assert one.place == other.place
        np.testing.assert_array_equal(one.T_object_estimated, other.T_object_estimated)


@pytest.mark.gl
def test_predictions_for_a_dataset_are_requested_where_its_records_have_the_pallets(tmp_path: Path) -> None:
    recipe = load_recipe("smoke")
    recipe = replace(recipe, scene=replace(recipe.scene, observations_per_scene=2), split=SplitConfig(0.0, 0.0, 1.0))
    data = tmp_path / "data"
    generate(recipe, data, GenerateConfig(seed=1, scenes=1, formats=("bop",), workers=1))
    off = make_transform(None, np.array([0.02, 0.0, 0.0]))
    moved = [replace(item, T_camera_object=item.T_camera_object @ off) for item in estimates_of(data)]
    poses = write_estimates(moved, tmp_path / "method_smoke-test.csv")
    verdicts = truck_verdicts(data, poses, "test", 3)
    rows = [json.loads(line) for line in (tmp_path / "answers.jsonl").read_text().splitlines()]
    stored = {item.instance_id: item for item in read_scene_record(data, 0).objects}
    assert len(verdicts) == len(rows) > 0
    for row in rows:
        assert (row["kind"], row["source"]) == ("predicted", "data method_smoke-test")
        assert stored[row["instance"]].accessibility.faces[row["face"]] in ("free", "under a stack")
        errors = row["swept"]["errors"]
        assert np.linalg.norm([errors[name] for name in ("depth", "lateral", "vertical")]) == pytest.approx(
            0.02, abs=1e-4
        )
    # Requested again, nothing is simulated again.
    before = (tmp_path / "answers.jsonl").read_bytes()
    assert truck_verdicts(data, poses, "test", 3) == verdicts
    assert (tmp_path / "answers.jsonl").read_bytes() == before


def judged(name: str, swept: Bool[np.ndarray, " n"], simulated: Bool[np.ndarray, " n"]) -> dict[str, Any]:
    """Return how often the swept-volume check and the simulated truck agree (``value``), and in what they differ."""
    return {
        "name": name,
        "value": float((swept == simulated).mean()),
        "n": len(swept),
        "both dock": int((swept & simulated).sum()),
        "swept only": int((swept & ~simulated).sum()),
        "simulation only": int((simulated & ~swept).sum()),
        "neither": int((~swept & ~simulated).sum()),
    }


@pytest.mark.slow
def test_the_check_agrees_with_the_truck_as_often_as_is_stored(tmp_path: Path) -> None:
    kept, rows = Kept(tmp_path / "answers.jsonl"), []
    for recipe in ("industrial", "mixed_pallets", "dock_staging"):
        rows += [answer(kept, question, station) for question, station in questions(recipe, 8 * len(KINDS))]
    swept, simulated = (np.array([docks(row) for row in rows]) for docks in (swept_docks, simulated_docks))
    places = [(row["source"], row["scene"]) for row in rows]
    scenes = np.array([list(dict.fromkeys(places)).index(place) for place in places])
    low, high = fraction_interval((swept == simulated).astype(float), scenes, 2000, np.random.default_rng(0))
    whole = judged("every pose", swept, simulated) | {"interval": [low, high], "scenes": len(set(places))}
    kinds = np.array([row["kind"] for row in rows])
    alone = [judged(kind, swept[kinds == kind], simulated[kinds == kind]) for kind in KINDS]
    stored = held("docking", __file__, [whole, *alone])["every pose"]
    assert low <= stored["value"] <= high
    assert (swept & ~simulated).sum() <= 0.02 * len(rows), "the check must not promise what the truck cannot do"
    assert all(simulated_docks(row) for row in rows if row["kind"] == "oracle")
    assert not any(simulated_docks(row) for row in rows if row["kind"] == "too deep")
