"""A rig names any registered sensor under ``more``; every sensor of a rig is mounted and read alike."""

from typing import Any

import numpy as np
import pytest

from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import ConfigError
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.sensors import SENSORS
from warehouse_sim.sensors.lidar import Lidar
from warehouse_sim.sensors.rgbd import RgbdConfig
from warehouse_sim.sensors.rgbd.color import IDEAL_COLOR
from warehouse_sim.sensors.rig import RigConfig
from warehouse_sim.sensors.stereo import StereoCamera, StereoConfig

PLAIN: dict[str, Any] = {
    "right": {"baseline": 0.3},
    "lidars": {"rear": {"lidar": "vlp16", "mount": {"carrier": "vehicle", "up": 1.0}}},
    "more": {
        "low": {"sensor": "rgbd", "depth": "d435", "color": "ideal", "mount": {"left": 0.2, "pitch_deg": -10}},
        "pair": {"sensor": "stereo", "baseline": 0.1, "color": "ideal", "mount": {"left": -0.1}},
    },
}


def rig_of(plain: dict[str, Any]) -> RigConfig:
    return from_mapping(RigConfig, plain, "here")


def test_a_rig_is_a_mapping_of_names_to_mounted_sensors() -> None:
    rig = rig_of(PLAIN)
    mounted = rig.mounted()
    assert list(mounted) == ["camera", "lidar", "rear", "right", "imu", "low", "pair"]
    assert [item.kind for item in mounted.values()] == ["rgbd", "lidar", "lidar", "stereo", "imu", "rgbd", "stereo"]
    assert mounted["camera"].sensor == RgbdConfig()
    assert mounted["rear"].sensor == Lidar(rig.lidars["rear"].lidar)
    assert mounted["right"].sensor == StereoCamera(StereoConfig(baseline=0.3), rig.rgbd.color)
    assert mounted["pair"].sensor == StereoCamera(StereoConfig(baseline=0.1), IDEAL_COLOR)
    assert all(isinstance(item.sensor, SENSORS.get(item.kind)) for item in mounted.values())


def test_frames_are_those_of_cameras_and_of_vehicles() -> None:
    mounted = rig_of(PLAIN).mounted()
    np.testing.assert_array_equal(mounted["camera"].T_camera_sensor(), np.eye(4))
    np.testing.assert_array_equal(mounted["right"].T_camera_sensor(), make_transform(translation=np.array([0.3, 0, 0])))
    np.testing.assert_allclose(mounted["pair"].T_camera_sensor(), make_transform(translation=np.array([0.1, 0, 0])))
    low = mounted["low"].T_camera_sensor()
    np.testing.assert_allclose(low[:3, 3], [-0.2, 0.0, 0.0])
    # It looks down by 10 deg: what lies on its axis sinks in the rig's camera, whose y points down.
    np.testing.assert_allclose(low[:3, 2], [0.0, np.sin(np.deg2rad(10)), np.cos(np.deg2rad(10))], atol=1e-12)
    np.testing.assert_allclose(mounted["lidar"].T_camera_sensor()[:3, 0], [0.0, 0.0, 1.0])


def test_every_sensor_has_a_stream_of_its_own_and_only_cameras_are_drawn_again_by_a_noise_paired_variant() -> None:
    mounted = rig_of(PLAIN).mounted()
    names = [item.stream_of(3) for item in mounted.values()]
    assert names == ["rgbd 3", "lidar 3", "lidar rear 3", "right 3", "imu 3", "sensor low 3", "sensor pair 3"]
    again = [item.stream_of(3, noise_sample=2) for item in mounted.values()]
    cameras = ["rgbd 3 draw 2", "right 3 draw 2", "sensor low 3 draw 2", "sensor pair 3 draw 2"]
    assert again == [*cameras[:1], "lidar 3", "lidar rear 3", cameras[1], "imu 3", *cameras[2:]]


def test_what_is_written_is_read_back() -> None:
    rig = rig_of(PLAIN)
    assert from_mapping(RigConfig, to_mapping(rig), "again") == rig
    assert to_mapping(rig)["more"]["low"]["sensor"] == "rgbd"
    assert to_mapping(rig)["more"]["low"]["depth"]["model"] == "active_stereo"
    assert "more" not in to_mapping(RigConfig())


@pytest.mark.parametrize(
    ("plain", "message"),
    [
        (
            {"more": {"ring": {"sensor": "sonar"}}},
            "here: more.ring: unknown sensor 'sonar'; known: imu, lidar",
        ),
        ({"more": {"ring": {"mount": {}}}}, "here: more.ring: expected {sensor: NAME} with its settings, found"),
        (
            {"more": {"low": {"sensor": "rgbd", "dept": 1}}},
            "here: more.low: dept is not a setting; did you mean 'depth'?",
        ),
        ({"more": {"low": {"sensor": "rgbd", "mount": {"lfet": 1}}}}, "here: more.low: mount: lfet is not a setting"),
        ({"more": {"top": {"sensor": "lidar"}}}, "here: more.top: a LiDAR is named under lidars, not under more"),
        ({"more": {"A b": {"sensor": "rgbd"}}}, "the name of a sensor is small letters, digits and _"),
        ({"more": {"camera": {"sensor": "rgbd"}}}, "needs a name of its own; camera: rename one"),
        ({"lidars": {"a": {"lidar": "vlp16"}}, "more": {"a": {"sensor": "rgbd"}}}, "of its own; a: rename one"),
        ({"lidars": {"right": {"lidar": "vlp16"}}, "right": {}}, "of its own; right: rename one"),
        ({"more": {f"c{n}": {"sensor": "rgbd"} for n in range(17)}}, "more must be at most 16 sensors, found 17"),
    ],
)
def test_wrong_settings_are_named_with_their_place(plain: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError) as caught:
        rig_of(plain)
    assert message in str(caught.value)
