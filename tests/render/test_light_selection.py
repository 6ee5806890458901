from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render.conformance.scenes import at, box_model, make_scene, spot
from warehouse_sim.render.light_selection import (
    facing_illuminance,
    point_ahead,
    reference_points,
    strongest_lights,
)
from warehouse_sim.schema import Viewpoint


def test_the_lights_kept_are_those_that_light_the_place_the_most_in_their_order() -> None:
    lights = [spot((x, 0, 5), 1000.0) for x in (-20, 4, 60)] + [spot((30, 0, 5), 1e6)]
    place = point_ahead(level_camera(np.array([0.0, 0, 1.5]), 0.0))
    assert strongest_lights(lights, None, place) == lights
    assert strongest_lights(lights, 2, place) == [lights[1], lights[3]]
    assert strongest_lights(lights[:3], 1, point_ahead(level_camera(np.array([0.0, 0, 1.5]), np.pi))) == [lights[1]]
    assert strongest_lights(lights[:3], 1, place - [30.0, 0, 0]) == [lights[0]]


def test_a_scene_is_looked_at_for_its_aisle_or_its_targets_or_what_its_lights_light() -> None:
    models = [box_model("floor", (9, 9, 0.1)), box_model("pallet", (1, 1, 1), class_name="pallet")]
    scene = make_scene(models, [("floor", at(0, 0, 0)), ("pallet", at(3, 1, 0))], [spot((0, 0, 6))])
    np.testing.assert_allclose(reference_points(scene), [[3, 1, 0]])
    np.testing.assert_allclose(reference_points(replace(scene, instances=scene.instances[:1])), [[0, 0, 2]])
    places = reference_points(replace(scene, aisle=(-4.0, 4.0, -3.0, 0.0)))
    np.testing.assert_allclose(places[:, :2].mean(axis=0), [0.0, -1.5], atol=1e-9)
    assert len(np.unique(places[:, 0])) == 4
    assert (places[:, 2] > 0.0).all()
    assert np.array_equal(reference_points(replace(scene, viewpoints=(Viewpoint(np.eye(4)),))), reference_points(scene))


def test_a_spot_gives_its_intensity_over_the_square_of_the_distance_within_its_cone() -> None:
    light = replace(spot((0, 0, 5), 900.0), cone_inner=0.3, cone_outer=0.6)
    points = np.array([[0, 0, 2.0], [0, 0, 8.0], [4, 0, 2.0]])
    np.testing.assert_allclose(facing_illuminance(light, points), [100.0, 0.0, 0.0])
    middle = np.arccos((np.cos(0.3) + np.cos(0.6)) / 2)
    rim = np.array([[3 * np.tan(middle), 0, 2.0]])
    assert facing_illuminance(light, rim)[0] == pytest.approx(900 / (3 / np.cos(middle)) ** 2 / 4)
