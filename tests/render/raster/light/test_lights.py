from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render.conformance.scenes import spot
from warehouse_sim.render.raster.light.lighting import LIGHT, MAX_LIGHTS, ShadedLight, light_records

T_WORLD_CAMERA = level_camera(np.array([0.0, 0.0, 1.5]), 0.0)


def test_records_hold_the_light_in_the_camera_frame() -> None:
    light = replace(spot((4.0, 1.0, 6.0), 500.0), color=(1.0, 0.5, 0.25), cone_inner=0.5, cone_outer=1.0)
    records = light_records([ShadedLight(light, None)], T_WORLD_CAMERA)
    assert records.dtype == LIGHT
    assert len(records) == MAX_LIGHTS
    np.testing.assert_allclose(records[0]["position"], [-1.0, -4.5, 4.0], atol=1e-6)
    np.testing.assert_allclose(records[0]["axis"], [0.0, 1.0, 0.0], atol=1e-6)
    np.testing.assert_allclose(records[0]["intensity"], [500.0, 250.0, 125.0])
    for angle, expected in ((0.5, 1.0), (1.0, 0.0)):
        value = np.cos(angle) * records[0]["cone_scale"] + records[0]["cone_offset"]
        assert value == pytest.approx(expected, abs=1e-5)
    assert not records[1:].view(np.uint8).any()
