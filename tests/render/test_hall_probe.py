"""What a hall looks like in all directions: more than six directions know, and no more light in all."""

from dataclasses import replace

import numpy as np
import pytest
from jaxtyping import Float32

from warehouse_sim.render.conformance.scenes import MATERIALS, at, box_model, make_scene, spot
from warehouse_sim.render.hall_probe import COLUMNS, ROUGHNESS, ROWS
from warehouse_sim.render.irradiance import LightGatherer
from warehouse_sim.render.light_grid import lay_grid
from warehouse_sim.schema import Material


def probe_of_room() -> Float32[np.ndarray, "levels rows columns"]:
    """A room of black walls but for the one at +x, seen from its middle."""
    sides = {"bright": (0.2, 8, 6), "dark": (0.2, 8, 6), "end": (12, 0.2, 6), "flat": (12, 8, 0.2)}
    models = [
        box_model(name, size, "bright" if name == "bright" else "black", "wall", number)
        for number, (name, size) in enumerate(sides.items(), 90)
    ]
    placed = [("bright", at(6, 0, 3)), ("dark", at(-6, 0, 3))]
    placed += [("end", at(0, y, 3)) for y in (-4, 4)] + [("flat", at(0, 0, z)) for z in (0, 6)]
    paint = {"bright": Material("bright", (0.8,) * 3), "black": Material("black", (0.02,) * 3)}
    lamp = replace(spot((0.0, 0.0, 5.5), 2000.0), kind="point", casts_shadow=False)
    scene = make_scene(models, placed, [lamp], materials={**MATERIALS, **paint}, ambient=0.0)
    return LightGatherer(lay_grid(scene)).field(scene.lights, scene.ambient).probe


def test_a_smooth_surface_mirrors_one_bright_wall_and_a_matt_one_hardly_knows_it() -> None:
    found = probe_of_room()
    assert found.shape == (len(ROUGHNESS), ROWS, COLUMNS)
    level = found[:, ROWS // 2]
    ahead, beside = level[:, [0, -1]].mean(axis=1), level[:, COLUMNS // 4]
    assert ahead[0] > 1.2
    assert beside[0] < 0.7
    assert np.all(np.diff(ahead - beside) < 0.0)
    assert abs(ahead[-1] - 1.0) < 0.1


def test_where_there_is_nothing_all_directions_are_alike() -> None:
    scene = make_scene(
        [box_model("floor", (1, 1, 0.1), "concrete", "floor", 90)], [("floor", at(0, 0, -0.05))], [], ambient=0.0
    )
    found = LightGatherer(lay_grid(scene)).field((), 0.0).probe
    assert found == pytest.approx(1.0)
