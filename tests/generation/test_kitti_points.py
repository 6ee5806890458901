"""In warehouses, too, a sweep of the kitti rig has within 15 % of the points that KITTI's sweeps have."""

from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene import sample_scene
from warehouse_sim.sensors.lidar import scan
from warehouse_sim.sensors.rig import RigConfig

# As in tests/sensors/lidar/test_kitti_parity.py, which does the same in streets.
KITTI_POINTS = 120_000


@pytest.mark.parametrize("name", ["industrial", "dock_staging", "block_storage", "selective_rack"])
def test_a_sweep_in_a_hall_has_about_as_many_points_as_kittis(name: str) -> None:
    rig = RigConfig.from_plain({"rig": "kitti"}, "here")
    assert rig.lidar is not None
    scene = sample_scene(load_recipe(name).scene, seed=0, scene_index=0)
    caster = RayCaster(scene)
    for number, viewpoint in enumerate(scene.viewpoints[:3]):
        T_world_lidar = viewpoint.T_world_camera @ rig.mounted()["lidar"].T_camera_sensor(viewpoint)
        points = scan(caster, rig.lidar, T_world_lidar, np.random.default_rng(number)).points
        # Walls and a roof close the view, so that nearly every one of the 133,312 pulses comes back.
        # But for those that end within the least range of the sensor, where racks stand beside a narrow aisle.
        eager = replace(rig.lidar, min_range=0.0)
        too_near = scan(caster, eager, T_world_lidar, np.random.default_rng(number)).points
        lost = int((np.linalg.norm(too_near, axis=1) < rig.lidar.min_range).sum())
        assert 1.05 * KITTI_POINTS < len(points) + lost < 1.15 * KITTI_POINTS
