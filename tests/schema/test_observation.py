"""An observation gives the readings of the usual sensors by kind, and those of any other by name."""

import pytest

from tests.dataset.toy import T_CAMERA_LIDAR, make_scene, observe
from warehouse_sim.schema import LidarScan, RgbdReading


def test_readings_are_found_by_kind() -> None:
    observation = observe(make_scene(0))[0]
    assert isinstance(observation.rgbd, RgbdReading)
    assert isinstance(observation.lidar, LidarScan)
    assert observation.T_camera_lidar is T_CAMERA_LIDAR
    assert observation.stereo is None
    assert observation.lidars == {}


@pytest.mark.parametrize("name", ["camera", "lidar"])
def test_a_sensor_stays_where_it_is_unless_told(name: str) -> None:
    observation = observe(make_scene(0))[0]
    again = observation.with_reading(name, observation.readings[name].reading)
    assert again.readings[name].T_camera_sensor is observation.readings[name].T_camera_sensor
