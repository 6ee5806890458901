"""Rows of light beside the aisle give the hall's floor what is asked for."""

import numpy as np
import pytest

from warehouse_sim.catalog.building.services import light_line
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.lighting.hall_light import fill_lights
from warehouse_sim.scene.lighting.photometry import unshadowed_illuminance
from warehouse_sim.schema import SceneSpec

WHITE = (1.0, 1.0, 1.0)


def hall(rows: int, length: float = 46.0) -> SceneSpec:
    draft = SceneDraft()
    for y in (np.arange(rows) - (rows - 1) / 2) * 6.0:
        draft.add(light_line(length), make_transform(translation=np.array([0.0, y, 7.5])))
    return SceneSpec(0, 0, draft.models, {}, tuple(draft.instances), (), ())


@pytest.mark.parametrize("rows", [4, 7])
def test_the_floor_under_the_rows_gets_the_lux_over_what_is_lost_on_the_way(rows: int) -> None:
    lights = fill_lights(hall(rows), 200.0, [WHITE])
    x, y = np.meshgrid(np.linspace(-15, 15, 31), np.linspace(-1, 1, 5) * 3.0 * (rows - 2))
    floor = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    lux = unshadowed_illuminance(lights, floor, np.tile([0.0, 0.0, 1.0], (len(floor), 1)))
    # Without walls and goods nothing is lost but what falls beyond the rows: between the wanted lux and that over 0.6.
    assert 200.0 < lux.mean() < 200.0 / 0.6 * 1.05
    assert lux.min() > 0.7 * lux.mean()


def test_they_are_few_and_all_fill() -> None:
    lights = fill_lights(hall(9), 100.0, [WHITE])
    assert 9 <= len(lights) <= 30
    assert all(light.fill and light.direction[2] == -1.0 for light in lights)


def test_a_hall_without_rows_or_with_dark_ones_has_none() -> None:
    assert fill_lights(hall(0), 200.0, [WHITE]) == ()
    assert fill_lights(hall(3), 0.0, [WHITE]) == ()


def test_rows_take_the_colours_of_the_luminaires_in_turn() -> None:
    warm = (1.3, 0.9, 0.5)
    lights = fill_lights(hall(4), 100.0, [WHITE, warm])
    by_row = {round(float(light.position[1]), 2): light.color for light in lights}
    assert [by_row[y] for y in sorted(by_row)] == [WHITE, warm, WHITE, warm]
