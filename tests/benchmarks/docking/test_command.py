"""Predictions for a dataset, asked by the command and answered once."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.docking.__main__ import main
from tests.evaluation.made_dataset import estimates_of, write_estimates
from warehouse_sim.dataset.split import SplitConfig
from warehouse_sim.dataset.stored.scene_record import read_scene_record
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.geometry.pose import make_transform


@pytest.mark.gl
def test_predictions_for_a_dataset_are_requested_where_its_records_have_the_pallets(tmp_path: Path, capsys) -> None:
    recipe = load_recipe("smoke")
    recipe = replace(recipe, scene=replace(recipe.scene, observations_per_scene=2), split=SplitConfig(0.0, 0.0, 1.0))
    data = tmp_path / "data"
    generate(recipe, data, GenerateConfig(seed=1, scenes=1, formats=("bop",), workers=1))
    off = make_transform(None, np.array([0.02, 0.0, 0.0]))
    moved = [replace(item, T_camera_object=item.T_camera_object @ off) for item in estimates_of(data)]
    poses = write_estimates(moved, tmp_path / "method_smoke-test.csv")
    main((f"{data}={poses}",), poses=3, folder=tmp_path / "out", pictures=0)
    assert "| 0 mm, mesh of the pallet |" in capsys.readouterr().out
    rows = [json.loads(line) for line in (tmp_path / "out" / "answers.jsonl").read_text().splitlines()]
    stored = {item.instance_id: item for item in read_scene_record(data, 0).objects}
    assert rows
    for row in rows:
        assert (row["kind"], row["source"]) == ("predicted", "data method_smoke-test")
        assert stored[row["instance"]].accessibility.faces[row["face"]] in ("free", "under a stack")
        errors = row["swept"]["errors"]
        assert np.linalg.norm([errors[name] for name in ("depth", "lateral", "vertical")]) == pytest.approx(
            0.02, abs=1e-4
        )
    # Asked again, nothing is simulated again.
    before = (tmp_path / "out" / "answers.jsonl").read_bytes()
    main((f"{data}={poses}",), poses=3, folder=tmp_path / "out")
    assert (tmp_path / "out" / "answers.jsonl").read_bytes() == before
