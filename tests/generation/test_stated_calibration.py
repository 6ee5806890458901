"""A recipe that lets the nominal calibration differ makes the same dataset, and says beside it what the rig states."""

from functools import partial
from pathlib import Path

import numpy as np
import pytest

from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.stored.scene_record import read_scene_record
from warehouse_sim.dataset.validate import validate
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import Recipe, load_recipe
from warehouse_sim.geometry.pose import invert
from warehouse_sim.scene.streams import scene_rng

pytestmark = pytest.mark.gl
SENSORS = {
    "camera": {"width": 480, "height": 240, "focal_px": 300, "distortion": {"k1": -0.05}},
    "lidar": "vlp16",
    "more": {"low": {"sensor": "rgbd", "depth": "d435", "mount": {"carrier": "vehicle", "up": 0.4}}},
}


def make(root: Path, **sensors: object) -> Recipe:
    plain = to_mapping(load_recipe("smoke"))
    plain["sensors"] = {**SENSORS, **sensors}
    plain["scene"]["observations_per_scene"] = 1
    recipe: Recipe = from_mapping(Recipe, plain, "here")
    generate(recipe, root, GenerateConfig(scenes=2, seed=5))
    return recipe


def test_only_the_record_differs_and_says_what_was_drawn(tmp_path: Path) -> None:
    with_errors, without = tmp_path / "with", tmp_path / "without"
    recipe = make(with_errors, calibration={})
    make(without)
    assert [check.detail for check in validate(with_errors) if not check.ok] == []
    files = [
        {p.relative_to(root): p.read_bytes() for p in root.rglob("*") if p.is_file()} for root in (with_errors, without)
    ]
    changed = {str(path) for path in files[0].keys() | files[1].keys() if files[0].get(path) != files[1].get(path)}
    told = {"manifest.json", "SHA256SUMS", "README.md", "card/recipe.yaml"}
    assert changed == told | {"scenes/000000.json", "scenes/000001.json"}
    true, nominal = DatasetReader(with_errors), DatasetReader(with_errors, "nominal")
    shifts = set()
    for split in true.splits:
        for a, b in zip(true.images(split), nominal.images(split), strict=True):
            assert recipe.sensors.calibration is not None
            stream = partial(scene_rng, 5, a.scene_id)
            error = recipe.sensors.calibration.sample(recipe.sensors.mounted(), stream)
            assert b.camera == error.camera(a.camera) != a.camera
            np.testing.assert_array_equal(nominal.depth(b), true.depth(a) * np.float32(error.depth_factor))
            row = read_scene_record(with_errors, a.scene_id).observations[a.image_id].nominal
            assert row is not None
            assert set(row.T_camera_sensor) == {"lidar", "low"}
            mine, theirs = true.readings(a)["low"], nominal.readings(b)["low"]
            np.testing.assert_array_equal(theirs.T_camera_sensor, row.T_camera_sensor["low"])
            np.testing.assert_allclose(
                invert(mine.T_camera_sensor) @ theirs.T_camera_sensor, error.T_sensor_nominal["low"], atol=1e-9
            )
            shifts.add(b.camera.cx - a.camera.cx)
    assert len(shifts) == 2, "another scene is another vehicle"
