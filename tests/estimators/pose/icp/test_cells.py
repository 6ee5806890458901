"""The table of cells against a slow search of all samples, and against the plane in closed form."""

import numpy as np
import pytest

from warehouse_sim.estimators.pose.icp.cells import NearestByCell, SurfaceCells
from warehouse_sim.estimators.pose.icp.surface import build_surface
from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.mesh import TriangleMesh, unit_box

SIZE = np.array([1.2, 0.8, 0.3])
EYE = np.array([2.0, 1.5, 1.0])
"""A camera that sees the three sides in the positive directions."""


def cells() -> SurfaceCells:
    mesh = TriangleMesh(box_corners(SIZE), unit_box().faces)
    return SurfaceCells(build_surface(mesh, 20_000, np.random.default_rng(0)))


def test_the_nearest_sample_is_at_most_a_cell_farther_than_that_of_a_slow_search() -> None:
    table = cells()
    surface = table.surface
    points = np.random.default_rng(1).uniform(-0.7, 0.7, (1, 500, 3)) * SIZE
    octant = table.octants(EYE[None])
    facing = np.flatnonzero((surface.normals @ np.ones(3) > 0)[surface.faces])
    found = table.samples_near(points, octant)[0]
    assert set(found.tolist()) <= set(facing.tolist())
    slow = np.linalg.norm(points[0][:, None] - surface.points[facing], axis=2).min(axis=1)
    away = np.linalg.norm(points[0] - surface.points[found], axis=1)
    # Half a diagonal of the point's cell and half one of the sample's.
    assert (away - slow).max() <= 2.0 * np.sqrt(3.0) * table.step


def test_over_a_face_the_distance_is_that_to_its_plane_and_behind_it_is_negative() -> None:
    table = cells()
    points = np.array([[[0.1, 0.1, 0.2], [0.1, 0.1, 0.13], [0.65, 0.0, 0.0], [0.0, 0.44, 0.05]]])
    distance, direction = NearestByCell([table], EYE[None]).nearest(points)
    np.testing.assert_allclose(distance[0], [0.05, -0.02, 0.05, 0.04], atol=1e-9)
    np.testing.assert_allclose(direction[0], np.eye(3)[[2, 2, 0, 1]], atol=1e-9)


def test_beside_all_faces_the_distance_points_away_from_the_nearest_edge() -> None:
    table = cells()
    distance, direction = NearestByCell([table], EYE[None]).nearest(np.array([[[0.8, 0.0, 0.35]]]))
    assert distance[0, 0] == pytest.approx(np.hypot(0.2, 0.2), abs=2.0 * table.step)
    assert direction[0, 0] @ np.array([1.0, 0.0, 1.0]) / np.sqrt(2.0) > 0.98


def test_rows_of_one_object_and_of_several_are_the_same_alone_and_together() -> None:
    first, second = cells(), cells()
    eyes = np.array([EYE, -EYE, EYE * [1, -1, 1]])
    points = np.random.default_rng(2).uniform(-0.6, 0.6, (3, 40, 3)) * SIZE
    together = NearestByCell([first, first, second], eyes).nearest(points)
    for row, table in enumerate((first, first, second)):
        alone = NearestByCell([table], eyes[row : row + 1]).nearest(points[row : row + 1])
        np.testing.assert_array_equal(alone[0][0], together[0][row])
        np.testing.assert_array_equal(alone[1][0], together[1][row])
