"""The scenes of ``industrial-v1`` are those that earlier numbers were measured on."""

import json
from dataclasses import replace

import pytest
import yaml

from benchmarks.speed.result import machine
from tests.generation import frozen
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.resources import data_folder

RESULT = json.loads(frozen.STORED.read_text())
STORED = {row["name"]: row["sha256"] for row in RESULT["rows"]}


@pytest.mark.gl
@pytest.mark.parametrize("index", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_a_frozen_scene_has_its_objects_cameras_depth_masks_and_labels(index: int) -> None:
    stored, found = STORED[f"industrial-v1 scene {index}"], frozen.scene_hashes(index)
    if RESULT["machine"]["processor"] != machine()["processor"]:
        # Another processor rounds otherwise: loads come to rest nanometres away, which no image or label shows.
        found["objects"] = stored["objects"]
    assert list(frozen.differences(stored, found, "")) == []


def test_every_frozen_scene_is_stored_whole() -> None:
    assert list(STORED) == [f"industrial-v1 scene {index}" for index in frozen.SCENES]
    for hashes in STORED.values():
        assert len(hashes["observations"]) == load_recipe("industrial-v1").scene.observations_per_scene
        for observation in hashes["observations"]:
            assert set(observation) == {"depth", "ids", "masks", "labels"}
            assert all(len(value) == 64 for value in observation.values())


def test_the_frozen_recipe_hangs_on_no_other() -> None:
    assert "extends" not in yaml.safe_load((data_folder("scenes") / "industrial-v1.yaml").read_text())


def test_a_pallet_moved_by_a_micrometre_is_seen() -> None:
    scene = prepare_scene(load_recipe("smoke"), 0, 0).scene
    first, *others = scene.instances
    T = first.T_world_object.copy()
    T[0, 3] += 1e-6
    moved = replace(scene, instances=(replace(first, T_world_object=T), *others))
    before, after = frozen.geometry_hashes(scene), frozen.geometry_hashes(moved)
    assert before["objects"] != after["objects"]
    assert before["cameras"] == after["cameras"]
    stored, found = before | {"observations": [{"depth": "a"}]}, after | {"observations": [{"depth": "b"}]}
    lines = list(frozen.differences(stored, found, "scene"))
    assert lines == ["scene: objects differ from the frozen ones", "scene: observation 0: depth differ"]
