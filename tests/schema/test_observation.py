"""An observation gives the readings of the usual sensors by kind, and those of any other by name."""

import numpy as np
import pytest

from tests.dataset.toy import T_CAMERA_LIDAR, make_scene, observe
from warehouse_sim.schema import ChannelReading, LidarScan, RgbdReading


def test_readings_are_found_by_kind() -> None:
    observation = observe(make_scene(0))[0]
    assert isinstance(observation.rgbd, RgbdReading)
    assert isinstance(observation.lidar, LidarScan)
    assert observation.T_camera_lidar is T_CAMERA_LIDAR
    assert observation.stereo is None
    assert observation.lidars == {}


def test_another_sensor_is_found_by_name_only() -> None:
    ring = ChannelReading({"distance": np.array([1.0, 2.0])})
    observation = observe(make_scene(0))[0].with_reading("ring", ring)
    assert observation.lidars == {}
    assert observation.readings["ring"].reading.channels["distance"].tolist() == [1.0, 2.0]
    assert "ring" not in observation.with_reading("ring", None).readings


def test_a_second_lidar_stands_beside_the_main_one() -> None:
    observation = observe(make_scene(0))[0]
    both = observation.with_reading("rear", observation.lidar, np.eye(4))
    assert list(both.lidars) == ["rear"]
    assert both.lidar is observation.lidar


@pytest.mark.parametrize("name", ["camera", "lidar"])
def test_a_sensor_stays_where_it_is_unless_told(name: str) -> None:
    observation = observe(make_scene(0))[0]
    again = observation.with_reading(name, observation.readings[name].reading)
    assert again.readings[name].T_camera_sensor is observation.readings[name].T_camera_sensor
