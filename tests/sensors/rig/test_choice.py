from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.config import from_mapping
from warehouse_sim.sensors.rgbd.depth import PRESETS
from warehouse_sim.sensors.rig import RigConfig, SensorChoice

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
