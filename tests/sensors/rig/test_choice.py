from collections import Counter

import numpy as np
import pytest

from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.sensors.rgbd import RgbdConfig
from warehouse_sim.sensors.rgbd.depth import PRESETS
from warehouse_sim.sensors.rig import RigConfig, SensorChoice

DRAWN = {
    "choices": [
        "d455",
        {"name": "dim tof", "weight": 3, "depth": {"preset": "flexx2", "noise_scale": 2.0}, "color": "raw"},
    ]
}


def test_a_rig_without_choices_has_its_own_camera_without_a_name() -> None:
    rig = from_mapping(RigConfig, {"rgbd": {"depth": "d435"}}, "here")
    assert rig.draw_sensor(np.random.default_rng(0)) == SensorChoice("", rig.rgbd)


def test_cameras_are_drawn_by_their_weights() -> None:
    rig = from_mapping(RigConfig, DRAWN, "here")
    drawn = [rig.draw_sensor(np.random.default_rng(seed)) for seed in range(800)]
    counted = Counter(choice.name for choice in drawn)
    assert counted["dim tof"] / 800 == pytest.approx(0.75, abs=0.05)
    (first,) = {choice.rgbd for choice in drawn if choice.name == "d455"}
    assert first == RgbdConfig(depth=PRESETS["d455"])


def test_choices_are_written_and_read_back() -> None:
    rig = from_mapping(RigConfig, DRAWN, "here")
    assert from_mapping(RigConfig, to_mapping(rig), "again") == rig
    assert "choices" not in to_mapping(RigConfig())
