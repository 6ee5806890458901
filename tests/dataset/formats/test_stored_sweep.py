"""Sweeps of our datasets, read for other formats: points lie on the floor and in the boxes of their objects."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.geometry.level_view import is_level
from warehouse_sim.geometry.pose import invert, transform_points
from warehouse_sim.scene.distribution import Distribution


@pytest.mark.gl
def test_sweeps_of_a_tilted_rig_are_in_the_frame_of_its_own_camera(tmp_path: Path) -> None:
    recipe = load_recipe("smoke", {"sensors": {"camera": {"width": 306, "height": 92, "focal_px": 180}}})
    roll = Distribution.constant(2.0)
    viewpoints = replace(recipe.scene.viewpoints, kind="forklift_mast", level=False, roll_deg=roll)
    recipe = replace(recipe, scene=replace(recipe.scene, viewpoints=viewpoints))
    generate(recipe, tmp_path / "data", GenerateConfig(scenes=1, seed=5, formats=("kitti", "bop")))
    reader, in_boxes = DatasetReader(tmp_path / "data"), 0
    for image in reader.images("train"):
        assert not is_level(image.T_world_camera)
        sweep = reader.sweep(image)
        assert sweep is not None
        points = transform_points(image.T_world_camera @ sweep.T_camera_sensor, sweep.reading.points.astype(float))
        assert -0.15 < np.percentile(points[:, 2], 1.0) < 0.05
        raw = np.fromfile(tmp_path / "data/kitti/training/velodyne" / f"{image.image_id:06d}.bin", "<f4").reshape(-1, 4)
        np.testing.assert_array_equal(sweep.reading.points, raw[:, :3])
        for target in image.targets:
            own = points[sweep.reading.instance_ids == target.instance_id]
            T_world_object = image.T_world_camera @ target.T_camera_object
            inside = np.abs(transform_points(invert(T_world_object), own))
            assert (inside <= reader.objects[target.obj_id].size / 2.0 + 0.15).all()
            in_boxes += len(own)
    assert in_boxes > 50
