"""Shipped rigs observe a settled scene: files and readings agree with each other and with the calibration."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import cv2
import numpy as np
import pytest

from tests.sensors.rig.reprojection import residuals
from warehouse_sim.dataset.formats.kitti.tolerant import OUR_SHAPES, read_calib, read_matrices
from warehouse_sim.dataset.formats.kitti.writer import calib_text
from warehouse_sim.dataset.store import DatasetStore
from warehouse_sim.dataset.stored.scene_record import Outcome
from warehouse_sim.dataset.validate import validate
from warehouse_sim.generation.observe import observe_scene
from warehouse_sim.generation.plan import GenerateConfig, plan_dataset
from warehouse_sim.generation.recipe import Recipe, load_recipe
from warehouse_sim.generation.recipe.paired_variants import base_variant
from warehouse_sim.generation.scene import sample_settled_scene
from warehouse_sim.geometry.pose import make_transform, transform_points
from warehouse_sim.render import Renderer
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import LidarScan, Observation, SceneSpec
from warehouse_sim.sensors.lidar import scan
from warehouse_sim.sensors.rgbd.color import ColorConfig
from warehouse_sim.sensors.rig import RigConfig, SensorChoice

pytestmark = pytest.mark.gl


@cache
def scene_of(kind: str) -> SceneSpec:
    recipe = load_recipe("smoke")
    views = replace(recipe.scene.viewpoints, kind=kind, height=None)
    scene = sample_settled_scene(replace(recipe, scene=replace(recipe.scene, viewpoints=views)), 0, 0).scene
    return scene


@pytest.fixture(scope="module")
def observe(renderer: Renderer) -> Callable[..., Observation]:
    """Return what gives the first observation of a rig."""

    def observed(rig: RigConfig, kind: str = "level") -> Observation:
        scene = scene_of(kind)
        return next(observe_scene(replace(scene, viewpoints=scene.viewpoints[:1]), rig, renderer))

    return observed


def rig_of(name: str) -> RigConfig:
    return RigConfig.from_plain({"rig": name}, "here")


def same_instances(observation: Observation, sweep: LidarScan, T_camera_lidar: np.ndarray) -> float:
    """Return at how many of the pixels whose depth is that of a point the image holds the point's instance, 0-1."""
    points = transform_points(T_camera_lidar, sweep.points.astype(float))
    ahead = points[:, 2] > 0.3
    u, v = np.rint(observation.camera.project(points[ahead])).astype(int).T
    inside = (u >= 0) & (u < observation.camera.width) & (v >= 0) & (v < observation.camera.height)
    z, ids = points[ahead, 2][inside], sweep.instance_ids[ahead][inside]
    u, v = u[inside], v[inside]
    met = np.abs(observation.buffers.depth[v, u] - z) < 0.02
    assert met.sum() > 400
    return float((observation.buffers.instance_mask[v, u] == ids)[met].mean())


@pytest.mark.parametrize(
    ("name", "kind"),
    [("kitti", "level"), ("forklift_mast", "forklift_mast"), ("forklift_forks", "forklift_forks"), ("amr", "amr")],
)
def test_the_calibration_that_is_written_is_the_one_that_was_used(observe, name: str, kind: str) -> None:
    rig = rig_of(name)
    assert rig.lidar is not None
    observation = observe(replace(rig, lidar=rig.lidar.ideal()), kind)
    assert observation.lidar is not None
    written = read_calib(calib_text(observation.camera, observation.T_camera_lidar), "calib")["Tr_velo_to_cam"]
    T_camera_lidar = make_transform(written[:, :3], written[:, 3])
    found = residuals(observation.lidar.points, T_camera_lidar, observation.buffers.depth, observation.camera)
    assert found.count > 500
    assert found.median_m < 1e-3
    assert found.shift_px < 0.1
    assert same_instances(observation, observation.lidar, T_camera_lidar) > 0.99
    # As read, noise is all that is added: half of the errors of a normal distribution lie within 0.6745 of its sigma.
    T_world_lidar = observation.T_world_camera @ T_camera_lidar
    noisy = scan(RayCaster(scene_of(kind)), rig.lidar, T_world_lidar, np.random.default_rng(0))
    as_read = residuals(noisy.points, T_camera_lidar, observation.buffers.depth, observation.camera)
    assert 0.5 * rig.lidar.range_noise < as_read.median_m < 1e-3 + 0.6745 * rig.lidar.range_noise
    assert set(observation.lidars) == set(rig.lidars)
    for item in observation.lidars.values():
        assert len(item.reading.points) > 20


def test_the_right_image_is_the_left_one_moved_by_the_true_disparity(observe) -> None:
    rig = rig_of("kitti")
    observation = observe(replace(rig, rgbd=replace(rig.rgbd, color=ColorConfig(noise_scale=0.0, exposure_error=0.0))))
    left, stereo = observation.buffers, observation.stereo
    assert stereo is not None
    P = read_matrices(calib_text(observation.camera, np.eye(4), 0.54), "c", OUR_SHAPES)
    assert P["P3"][0, 3] == pytest.approx(-721.5377 * 0.54)
    np.testing.assert_allclose(stereo.disparity[left.depth > 0], -P["P3"][0, 3] / left.depth[left.depth > 0], rtol=1e-5)
    v, u = np.mgrid[: observation.camera.height, : observation.camera.width].astype(np.float32)
    there = u - stereo.disparity
    depth = cv2.remap(stereo.buffers.depth, there, v, cv2.INTER_LINEAR)
    visible = (there >= 0) & (left.depth > 0) & (np.abs(depth - left.depth) < 0.01 * left.depth)
    assert visible.mean() > 0.4
    ids = cv2.remap(stereo.buffers.instance_mask.astype(np.float32), there, v, cv2.INTER_NEAREST)
    assert (ids == left.instance_mask)[visible].mean() > 0.99
    np.testing.assert_array_equal(stereo.in_both & (there < 0), False)
    assert (stereo.in_both == visible)[there >= 0].mean() > 0.98
    moved = cv2.remap(stereo.buffers.rgb, there, v, cv2.INTER_LINEAR).astype(float)
    assert np.median(np.abs(moved - left.rgb)[visible]) <= 2.0
    still = np.abs(stereo.buffers.rgb.astype(float) - left.rgb)[visible]
    assert np.mean(np.abs(moved - left.rgb)[visible]) < 0.4 * np.mean(still)


def test_matching_the_noisy_pair_is_right_where_there_is_texture(observe) -> None:
    observation = observe(rig_of("kitti"))
    assert observation.stereo is not None
    matched, true = observation.stereo.matched, observation.stereo.disparity
    assert matched is not None
    grey = cv2.GaussianBlur(cv2.cvtColor(observation.buffers.rgb, cv2.COLOR_RGB2GRAY).astype(np.float32), (0, 0), 1.0)
    textured = np.abs(cv2.Sobel(grey, cv2.CV_32F, 1, 0)) > 20.0
    found = textured & (matched > 0) & (true > 0)
    assert found.sum() > 3000
    assert np.median(np.abs(matched - true)[found]) < 1.0


def with_rig(recipe: Recipe, rig: RigConfig) -> Recipe:
    return replace(recipe, sensors=rig, scene=replace(recipe.scene, observations_per_scene=1))


def test_the_files_of_a_rig_pass_validation(observe, tmp_path) -> None:
    more = {"rear": {"lidar": "safety2d", "mount": {"carrier": "vehicle", "up": 0.3, "yaw_deg": 180}}}
    recipe = with_rig(
        load_recipe("smoke"),
        RigConfig.from_plain({"rig": "kitti", "lidars": more, "outputs": ["default", "clean"]}, "here"),
    )
    plan = plan_dataset(recipe, GenerateConfig(scenes=1, formats=("kitti",)))
    store = DatasetStore(tmp_path / "data", plan.manifest)
    store.begin(plan.models, plan.camera)
    observation = observe(recipe.sensors)
    scene = replace(scene_of("level"), viewpoints=scene_of("level").viewpoints[:1])
    store.write_scene(scene, [observation], Outcome({}, "raster"))
    store.finish()
    failed = [check for check in validate(tmp_path / "data") if not check.ok]
    assert failed == []
    (folder,) = (path.parent.parent for path in (tmp_path / "data/kitti").rglob("image_3/000000.png"))
    steps = cv2.imread(str(folder / "disp_occ/000000.png"), cv2.IMREAD_UNCHANGED)
    assert steps.dtype == np.uint16
    assert observation.stereo is not None
    fits = observation.stereo.disparity < 255.9
    assert np.abs(steps / 256.0 - observation.stereo.disparity)[fits].max() < 1 / 256
    seen = cv2.imread(str(folder / "disp_noc/000000.png"), cv2.IMREAD_UNCHANGED)
    assert np.array_equal(seen, np.where(observation.stereo.in_both, steps, 0))
    assert 0.4 < (seen > 0).mean() < (steps > 0).mean()
    clean = cv2.imread(str(folder / "depth_clean_2/000000.png"), cv2.IMREAD_UNCHANGED) / 256.0
    assert np.abs(clean - observation.buffers.depth).max() <= 0.5 / 256 + 1e-5
    assert np.array_equal(cv2.imread(str(folder / "image_clean_2/000000.png"))[..., ::-1], observation.buffers.rgb)
    assert plan.manifest.recipe["sensors"]["outputs"] == ["default", "clean"]
    right = cv2.imread(str(folder / "image_3/000000.png"))[..., ::-1]
    assert np.array_equal(right, observation.stereo.rgb)
    cloud = np.fromfile(folder / "velodyne_rear/000000.bin", "<f4").reshape(-1, 4)
    assert np.array_equal(cloud[:, :3], observation.lidars["rear"].reading.points)
    name, *numbers = (folder / "calib_lidars/000000.txt").read_text().split()
    assert name == "Tr_rear_to_cam:"
    np.testing.assert_allclose(
        np.array(numbers, float), observation.lidars["rear"].T_camera_sensor[:3].ravel(), atol=1e-9
    )
    (folder / "image_3/000000.png").unlink()
    assert any("image_3" in check.detail for check in validate(tmp_path / "data") if not check.ok)


def test_the_right_image_has_a_noise_stream_of_its_own_and_paired_variants_share_what_light_leaves_alone(
    renderer,
) -> None:
    rig, scene = rig_of("kitti"), scene_of("level")
    scene = replace(scene, viewpoints=scene.viewpoints[:1])
    base = base_variant(scene, SensorChoice("", rig.rgbd))
    noisier = replace(base, name="another draw", noise_sample=1)
    first, paired_variant = observe_scene(scene, rig, renderer, (base, noisier))
    (again,) = observe_scene(scene, rig, renderer)
    assert first.stereo is not None
    assert paired_variant.stereo is not None
    assert again.stereo is not None
    assert np.array_equal(first.stereo.rgb, again.stereo.rgb)
    assert not np.array_equal(first.stereo.rgb, paired_variant.stereo.rgb)
    assert np.array_equal(first.stereo.disparity, paired_variant.stereo.disparity)
    assert first.readings["lidar"] is paired_variant.readings["lidar"]


def test_a_sweep_is_bent_by_the_viewpoints_motion_if_requested(observe, renderer) -> None:
    scene = scene_of("level")
    moving = replace(scene.viewpoints[0], velocity=(1.5, 0.0, 0.0), yaw_rate=0.3)
    scene = replace(scene, viewpoints=(moving,))
    clouds = {}
    for motion in ("ignored", "raw"):
        rig = RigConfig.from_plain({"camera": "kitti", "lidar": {"motion": motion}}, "here")
        (observation,) = observe_scene(scene, rig, renderer)
        assert observation.lidar is not None
        clouds[motion] = observation.lidar
    still = observe(RigConfig()).lidar
    assert still is not None
    assert np.array_equal(clouds["ignored"].points, still.points)
    size = min(len(clouds["raw"].points), len(still.points))
    assert size > 1000
    assert not np.array_equal(clouds["raw"].points[:size], still.points[:size])
