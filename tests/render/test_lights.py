from dataclasses import replace

import numpy as np
import pytest

from tests.render.scenes import spot
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render.raster.lights import LIGHT, MAX_LIGHTS, ShadedLight, choose_lights, light_records
from warehouse_sim.render.raster.shadows import MAX_SHADOWS

T_WORLD_CAMERA = level_camera(np.array([0.0, 0.0, 1.5]), 0.0)


def test_lamps_with_a_map_come_first_and_all_keep_their_order() -> None:
    far, near, behind = spot((30, 0, 6)), spot((4, 1, 6)), spot((-9, 0, 6))
    plain = replace(near, casts_shadow=False)
    point = replace(near, kind="point")
    assert choose_lights([plain, far, point, behind, near], T_WORLD_CAMERA) == ([far, behind, near], [plain, point])


def test_of_too_many_lamps_those_are_kept_that_light_what_is_before_the_camera() -> None:
    lamps = [spot((4, 0, 6), 1000.0 + 100.0 * (7 * k % 20)) for k in range(20)]
    with_map, without = choose_lights(lamps, T_WORLD_CAMERA)
    ranked = sorted(lamps, key=lambda light: -light.intensity)
    assert with_map == [light for light in lamps if light in ranked[:MAX_SHADOWS]]
    assert without == [light for light in lamps if light in ranked[MAX_SHADOWS:MAX_LIGHTS]]
    row = [spot((x, 0, 6)) for x in np.arange(-40.0, 41.0, 4.0)]
    behind = choose_lights(row, level_camera(np.array([0.0, 0.0, 1.5]), np.pi))[0]
    assert max(light.position[0] for light in behind) < max(
        light.position[0] for light in choose_lights(row, T_WORLD_CAMERA)[0]
    )


def test_records_hold_the_lamp_in_the_camera_frame() -> None:
    lamp = replace(spot((4.0, 1.0, 6.0), 500.0), color=(1.0, 0.5, 0.25), cone_inner=0.5, cone_outer=1.0)
    records = light_records([ShadedLight(lamp, None)], T_WORLD_CAMERA)
    assert records.dtype == LIGHT
    assert len(records) == MAX_LIGHTS
    np.testing.assert_allclose(records[0]["position"], [-1.0, -4.5, 4.0], atol=1e-6)
    np.testing.assert_allclose(records[0]["axis"], [0.0, 1.0, 0.0], atol=1e-6)
    np.testing.assert_allclose(records[0]["intensity"], [500.0, 250.0, 125.0])
    for angle, expected in ((0.5, 1.0), (1.0, 0.0)):
        value = np.cos(angle) * records[0]["cone_scale"] + records[0]["cone_offset"]
        assert value == pytest.approx(expected, abs=1e-5)
    assert not records[1:].view(np.uint8).any()


def test_the_record_has_the_size_of_the_shaders_array_element() -> None:
    assert LIGHT.itemsize == 9 * 16  # nine vec4 in std140
