"""The calibration of a rig is the one by which its sensors see."""

import numpy as np
import pytest

from tests.sensors.rig.reprojection import residuals
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import make_transform, rotation_y, rotation_z
from warehouse_sim.render.conformance.scenes import rack_wall
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import SceneSpec, Viewpoint
from warehouse_sim.sensors.lidar import LIDAR_PRESETS, scan
from warehouse_sim.sensors.rig import RigConfig


@pytest.fixture(scope="module")
def scene() -> SceneSpec:
    return rack_wall()


@pytest.fixture(scope="module")
def caster(scene: SceneSpec) -> RayCaster:
    return RayCaster(scene)


def depth_of(caster: RayCaster, camera: PinholeCamera, T_world_camera: np.ndarray) -> np.ndarray:
    rays = camera.rays().reshape(-1, 3) @ T_world_camera[:3, :3].T
    hits = caster.cast(np.broadcast_to(T_world_camera[:3, 3], rays.shape), rays)
    return np.where(np.isfinite(hits.distance), hits.distance, 0.0).reshape(camera.height, camera.width)


@pytest.mark.parametrize("lens", [None, "kitti_raw", "wide"])
@pytest.mark.parametrize("name", ["amr", "forklift_forks", "forklift_mast", "kitti"])
def test_points_lie_on_the_depth_image_and_not_under_another_calibration(
    name: str, lens: str | None, scene: SceneSpec, caster: RayCaster
) -> None:
    rig = RigConfig.from_plain({"rig": name} if lens is None else {"rig": name, "camera": lens}, "here")
    T_world_camera = scene.viewpoints[3].T_world_camera
    T_world_vehicle = make_transform(rotation_z(-0.45), np.array([-0.3, 2.6, 0.0]))
    viewpoint = Viewpoint(T_world_camera, T_world_vehicle=T_world_vehicle)
    T_camera_lidar = rig.mounted()["lidar"].T_camera_sensor(viewpoint)
    lidar = LIDAR_PRESETS["hdl64e"].ideal()
    sweep = scan(caster, lidar, T_world_camera @ T_camera_lidar, np.random.default_rng(0))
    camera = rig.make_camera()
    depth = depth_of(caster, camera, T_world_camera)
    found = residuals(sweep.points, T_camera_lidar, depth, camera)
    assert found.count > 3000
    assert found.median_m < 1e-3
    assert found.shift_px < 0.1
    turned = residuals(
        sweep.points, T_camera_lidar @ make_transform(rotation_z(0.003) @ rotation_y(0.003)), depth, camera
    )
    assert turned.median_m > 1e-3
    assert turned.shift_px > 0.5
