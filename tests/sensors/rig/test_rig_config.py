from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.errors import one_line
from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import ConfigError
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.geometry.lens import Distortion
from warehouse_sim.resources import data_folder
from warehouse_sim.sensors.lidar import LidarConfig
from warehouse_sim.sensors.rgbd import RgbdConfig
from warehouse_sim.sensors.rgbd.depth import PRESETS
from warehouse_sim.sensors.rig import CameraConfig, RigConfig, SensorChoice


def test_what_is_written_is_read_back() -> None:
    data = {"camera": {"width": 64, "height": 48, "focal_px": 50}, "lidar": {"azimuth_range_deg": [-45, 45]}}
    rig = from_mapping(RigConfig, data, "here")
    assert from_mapping(RigConfig, to_mapping(rig), "again") == rig
    assert set(to_mapping(rig)) == {"camera", "rgbd", "lidar", "lidar_position", "imu"}


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ({"camera": "kitty"}, "'kitty' is no camera preset (did you mean 'kitti'?); known: azure_kinect, d435, "),
        ({"camera": {"widht": 3}}, "here: camera: widht is not a setting; did you mean 'width'?"),
        ({"right": {"matching": {"disparities": 100}}}, "disparities must be a multiple of 16, found 100"),
        ({"lidars": {"ids": {"lidar": "vlp16"}}}, "not ids or beams; found 'ids'"),
        ({"lidars": {"a_b": {"lidar": "vlp16"}}}, "is small letters and digits, not ids or beams; found 'a_b'"),
        ({"lidar": None, "lidars": {"a": {"lidar": "vlp16"}}}, "give lidar, too"),
        ({"choices": ["d455", "d455"]}, "every one of choices needs a name of its own, found ['d455', 'd455']"),
        ({"choices": ["d456"]}, "d456"),
        ({"choices": [{"depth": "d455"}]}, "expected a depth preset's name, or {name: ..., depth: ..., color: ...}"),
        (
            {"lidar_mount": {"carrier": "roof"}},
            "lidar_mount: carrier must be one of 'camera', 'upright', 'vehicle', found",
        ),
    ],
)
def test_wrong_settings_are_named_with_their_place(data: dict, message: str) -> None:
    with pytest.raises(ConfigError) as caught:
        from_mapping(RigConfig, data, "here")
    assert message in str(caught.value)


def test_a_lens_is_read_and_written_only_where_there_is_one() -> None:
    spelled = {"width": 640, "height": 360, "focal_px": 500, "distortion": {"k1": -0.2, "p2": 0.001}}
    rig = from_mapping(RigConfig, {"camera": spelled}, "here")
    assert rig.make_camera().distortion == Distortion(k1=-0.2, p2=0.001)
    assert from_mapping(RigConfig, to_mapping(rig), "again") == rig
    assert "distortion" not in to_mapping(RigConfig())["camera"]
    nothing = from_mapping(RigConfig, {"camera": {"distortion": {"k1": 0}}}, "here")
    assert nothing.make_camera() == RigConfig().make_camera()


@pytest.mark.parametrize(
    ("camera", "message"),
    [
        ({"preset": "kitti", "distortion": {"k1": -0.37, "k2": 0.2, "k3": -0.07}}, "inside its borders"),
        ({"distortion": {"k4": 0.1}}, "here: camera: distortion: k4 is not a setting; known: k1, k2, p1, p2, k3"),
        ({"preset": "gopro"}, "'gopro' is no camera preset; known: azure_kinect, d435, "),
    ],
)
def test_a_lens_that_cannot_be_is_named_with_its_place(camera: dict, message: str) -> None:
    with one_line(ConfigError, message):
        from_mapping(RigConfig, {"camera": camera}, "here")


def test_a_preset_can_be_changed_in_part() -> None:
    camera = from_mapping(RigConfig, {"camera": {"preset": "kitti_raw", "height": 376}}, "here").make_camera()
    raw = from_mapping(RigConfig, {"camera": "kitti_raw"}, "here").make_camera()
    assert camera == replace(raw, height=376)


def test_the_wide_preset_shows_equal_angles_as_equal_lengths() -> None:
    camera = from_mapping(RigConfig, {"camera": "wide"}, "here").make_camera()
    rays = camera.rays()
    angle = np.arctan(np.hypot(rays[..., 0], rays[..., 1]))
    u, v = np.meshgrid(np.arange(camera.width) - camera.cx, np.arange(camera.height) - camera.cy)
    assert np.abs(np.hypot(u, v) / camera.fx - angle).max() < 0.003
    ends = rays[360, 0, 0], rays[360, -1, 0], rays[0, 640, 1], rays[-1, 640, 1]
    left, right, top, bottom = np.degrees(np.arctan(ends))
    assert (round(right - left), round(bottom - top)) == (95, 53)


@pytest.mark.parametrize(
    ("name", "size", "hfov_deg", "baseline"),
    [
        ("d435", (848, 480), 87.0, 0.050),
        ("d435_720p", (1280, 720), 87.0, 0.050),
        ("d455", (848, 480), 87.0, 0.095),
        ("d455_720p", (1280, 720), 87.0, 0.095),
    ],
)
def test_a_stereo_camera_by_name_has_the_angle_of_its_sheet_and_its_own_depth(name, size, hfov_deg, baseline) -> None:
    rig = RigConfig.from_plain({"camera": name}, "here")
    assert (rig.camera.width, rig.camera.height) == size
    assert np.degrees(2 * np.arctan(size[0] / 2 / rig.camera.focal_px)) == pytest.approx(hfov_deg, abs=0.05)
    assert (rig.rgbd.depth.kind, rig.rgbd.depth.baseline) == ("active_stereo", baseline)
    # The infrared cameras see 90 deg over the same width.
    assert rig.rgbd.depth.focal_px == pytest.approx(size[0] / 2, rel=0.06)


def test_a_camera_by_name_leaves_a_depth_that_is_given() -> None:
    given = RigConfig.from_plain({"camera": "d435", "rgbd": {"depth": "flexx2"}}, "here")
    assert given.rgbd.depth.kind == "time_of_flight"
    plain = RigConfig.from_plain({"camera": "kitti"}, "here")
    assert plain.rgbd == RgbdConfig()
    over = RigConfig.from_plain({"rig": "forklift_mast", "camera": "d435_720p"}, "here")
    assert over.rgbd.depth == RigConfig.from_plain({"camera": "d435_720p"}, "here").rgbd.depth


def test_an_angle_stands_for_a_focal_length() -> None:
    camera = CameraConfig.from_plain({"width": 1000, "height": 500, "hfov_deg": 90}, "here")
    assert camera.focal_px == pytest.approx(500.0)
    assert CameraConfig.from_plain(camera.to_plain(), "here") == camera
    for wrong, words in (({"hfov_deg": 90, "focal_px": 500}, "give one of them"), ({"hfov_deg": 1.2}, "5-170 degrees")):
        with pytest.raises(ConfigError, match=words):
            CameraConfig.from_plain({"width": 1000, "height": 500} | wrong, "here")


def test_os1_has_as_many_beams_as_its_name_says() -> None:
    beams = {name: RigConfig.from_plain({"lidar": name}, "here").lidar for name in ("os1_128", "os1_64", "os1_32")}
    assert [item.rays_per_turn // 2048 for item in beams.values()] == [128, 64, 32]
    assert LidarConfig.from_plain(to_mapping(beams["os1_64"]), "here") == beams["os1_64"]
    changed = LidarConfig.from_plain({"model": "os1_64", "max_range": 50.0}, "here")
    assert (changed.every_nth_beam, changed.max_range) == (2, 50.0)


RENDERED = {
    "choices": [
        "d455",
        {"name": "dim tof", "weight": 3, "depth": {"preset": "flexx2", "noise_scale": 2.0}, "color": "raw"},
    ]
}


def test_a_rig_without_choices_has_its_own_camera_without_a_name() -> None:
    rig = from_mapping(RigConfig, {"rgbd": {"depth": "d435"}}, "here")
    sampled = rig.sample_sensor(np.random.default_rng(0))
    depth = replace(rig.rgbd.depth, unit=sampled.rgbd.depth.unit)
    assert sampled == SensorChoice("", replace(rig.rgbd, depth=depth))


def test_each_scene_has_another_built_camera_unless_its_number_is_given() -> None:
    rig = from_mapping(RigConfig, {"rgbd": {"depth": "d435"}}, "here")
    units = {rig.sample_sensor(np.random.default_rng(seed)).rgbd.depth.unit for seed in range(20)}
    assert None not in units
    assert len(units) == 20
    given = from_mapping(RigConfig, {"rgbd": {"depth": {"preset": "d435", "unit": 7}}}, "here")
    assert {given.sample_sensor(np.random.default_rng(seed)).rgbd.depth.unit for seed in range(5)} == {7}


def test_cameras_are_drawn_by_their_weights() -> None:
    rig = from_mapping(RigConfig, RENDERED, "here")
    sampled = [rig.sample_sensor(np.random.default_rng(seed)) for seed in range(800)]
    counted = Counter(choice.name for choice in sampled)
    assert counted["dim tof"] / 800 == pytest.approx(0.75, abs=0.05)
    (first,) = {replace(choice.rgbd.depth, unit=None) for choice in sampled if choice.name == "d455"}
    assert first == PRESETS["d455"]


def rig(data: dict) -> RigConfig:
    return RigConfig.from_plain(data, "here")


def test_kitti_has_the_geometry_of_kitti() -> None:
    found = rig({"rig": "kitti"})
    camera = found.make_camera()
    assert (camera.width, camera.height, camera.fx, camera.fy) == (1224, 370, 721.5377, 721.5377)
    assert found.camera_height == 1.65
    assert found.lidar is not None
    assert found.lidar.model == "hdl64e"
    assert found.right is not None
    assert found.right.baseline == 0.54
    T_camera_lidar = found.mounted()["lidar"].T_camera_sensor()
    assert found.camera_height - T_camera_lidar[1, 3] == pytest.approx(1.73)
    np.testing.assert_allclose(T_camera_lidar, [[0, -1, 0, 0], [0, 0, -1, -0.08], [1, 0, 0, -0.27], [0, 0, 0, 1]])
    assert np.array_equal(T_camera_lidar, RigConfig().mounted()["lidar"].T_camera_sensor())


def test_settings_of_the_recipe_replace_those_of_the_rig() -> None:
    found = rig({"rig": "amr", "lidar": "os1_128", "lidars": {}})
    assert found.lidar is not None
    assert found.lidar.model == "os1_128"
    assert found.lidars == {}
    assert found.lidar_mount == rig({"rig": "amr"}).lidar_mount


def test_a_rig_can_be_a_file(tmp_path: Path) -> None:
    path = tmp_path / "own.yaml"
    path.write_text("lidar: vlp16\nlidar_mount: {carrier: camera, up: 0.3}\n")
    assert rig({"rig": str(path)}).mounted()["lidar"].T_camera_sensor()[1, 3] == pytest.approx(-0.3)
    path.write_text("lidar_mout: {up: 0.3}\n")
    with pytest.raises(ConfigError, match="lidar_mout is not a setting; did you mean 'lidar_mount'"):
        rig({"rig": str(path)})


@pytest.mark.parametrize(
    ("name", "message"), [("kity", "here: rig: .*kitti"), ("no.yaml", "no.yaml: cannot be read"), (3, "here: rig")]
)
def test_an_unknown_rig_is_named(name: object, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        rig({"rig": name})


def test_a_recipe_takes_the_rigs_camera_height_unless_it_names_one(tmp_path: Path) -> None:
    text = (data_folder("scenes") / "smoke.yaml").read_text().replace("rig: dissertation", "rig: kitti")
    path = tmp_path / "with_height.yaml"
    path.write_text(text)
    assert load_recipe(str(path)).scene.viewpoints == load_recipe("smoke").scene.viewpoints
    path.write_text(text.replace("    height: {min: 0.4, max: 2.5}\n", ""))
    height = load_recipe(str(path)).scene.viewpoints.height
    assert height is not None
    assert (height.low, height.high) == (1.65, 1.65)
