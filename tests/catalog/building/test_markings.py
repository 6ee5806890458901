import numpy as np
import pytest

from tests.catalog.covering import shipped
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.building.floor_marks import TYRE_TRACK

FLAT = [name for name in shipped("building") if catalog_object(name).class_name == "marking"]


@pytest.mark.parametrize("name", FLAT)
def test_what_is_painted_is_flat_and_stops_nothing(name: str) -> None:
    model = catalog_object(name)
    assert model.size[2] <= 0.001
    assert model.collision == ()
    assert model.mass == 0.0


def test_both_colours_of_a_line_are_one_geometry() -> None:
    yellow, white = catalog_object("lane_line_yellow_3000"), catalog_object("lane_line_white_3000")
    assert yellow.obj_id == white.obj_id
    assert (yellow.parts[0].material, white.parts[0].material) == ("marking_yellow", "marking_white")


def test_straight_tyre_marks_are_two_tracks_apart_that_thin_out() -> None:
    vertices = catalog_object("tyre_mark_straight").mesh().vertices
    for side in (-1.0, 1.0):
        track = vertices[np.sign(vertices[:, 1]) == side]
        assert track[:, 1].mean() == pytest.approx(side * TYRE_TRACK / 2)
        ends = track[track[:, 0] > track[:, 0].max() - 1e-9]
        middle = track[np.abs(track[:, 0]) < 0.15]
        assert np.ptp(ends[:, 1]) < 0.25 * np.ptp(middle[:, 1])


def test_a_curved_tyre_mark_runs_on_two_circles() -> None:
    model = catalog_object("tyre_mark_curve")
    vertices = model.mesh().vertices
    # The ring's centre is the corner of the bounding box that the tracks bend around.
    outer = vertices[np.argmax(vertices[:, 0])]
    centre = np.array([outer[0] - 2.4, outer[1]])
    radius = np.linalg.norm(vertices[:, :2] - centre, axis=1)
    assert set(np.round((radius - 2.4) / TYRE_TRACK)) == {0.0, -1.0}
