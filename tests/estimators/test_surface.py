import numpy as np
import pytest
import trimesh

from tests.dataset.toy import PALLET
from warehouse_sim.estimators.surface import build_surface, closest_points, inside
from warehouse_sim.geometry.mesh import unit_box

SURFACE = build_surface(PALLET.mesh(), 6000, np.random.default_rng(0))


def test_faces_covered_by_another_part_are_gone() -> None:
    # The skids carry the deck at z = 0.032; their tops and the deck above them touch.
    covered = (np.abs(SURFACE.points[:, 2] - 0.032) < 1e-9) & (np.abs(np.abs(SURFACE.points[:, 0]) - 0.5) < 0.1)
    assert not covered.any()
    open_deck = (np.abs(SURFACE.points[:, 2] - 0.032) < 1e-9) & (np.abs(SURFACE.points[:, 0]) < 0.4)
    assert open_deck.sum() > 300


def test_inside_agrees_with_the_boxes() -> None:
    rng = np.random.default_rng(1)
    points = rng.uniform(-0.8, 0.8, (500, 3)) * [1, 1, 0.15]
    mesh = PALLET.mesh()
    expected = np.zeros(len(points), dtype=bool)
    for part in PALLET.parts:
        local = points - part.T_object_part[:3, 3]
        expected |= (np.abs(local) < part.scale / 2).all(axis=1)
    assert 20 < expected.sum() < 480
    np.testing.assert_array_equal(inside(mesh.vertices[mesh.faces], points), expected)


def test_closest_points_are_those_of_trimesh() -> None:
    rng = np.random.default_rng(2)
    corners, points = rng.normal(size=(400, 3, 3)), rng.normal(size=(400, 3)) * 2
    expected = trimesh.triangles.closest_point(corners, points)
    np.testing.assert_allclose(closest_points(points, corners), expected, atol=1e-9)


def test_distance_before_a_face_is_signed_and_along_its_normal() -> None:
    surface = build_surface(unit_box(), 4000, np.random.default_rng(0)).seen_from(np.array([5.0, 0, 0]), 1.0)
    distance, direction = surface.nearest(np.array([[0.7, 0.1, -0.2], [0.45, 0.3, 0.1]]))
    np.testing.assert_allclose(distance, [0.2, -0.05], atol=1e-12)
    np.testing.assert_allclose(direction, [[1, 0, 0]] * 2, atol=1e-12)


def test_distance_beside_a_face_grows_away_from_its_edge() -> None:
    surface = build_surface(unit_box(), 4000, np.random.default_rng(0)).seen_from(np.array([5.0, 0, 0]), 1.0)
    distance, direction = surface.nearest(np.array([[0.5, 0.8, 0.0]]))
    np.testing.assert_allclose(distance, [0.3], atol=1e-12)
    np.testing.assert_allclose(direction, [[0, 1, 0]], atol=1e-12)


@pytest.mark.parametrize("squash", [1.0, 0.2])
def test_gradient_of_the_squashed_distance(squash: float) -> None:
    visible = SURFACE.seen_from(np.array([4.0, 1.5, 0.8]), squash)
    rng = np.random.default_rng(3)
    points = SURFACE.points[rng.integers(0, len(SURFACE.points), 200)] + rng.normal(0, 0.02, (200, 3))
    distance, gradient = visible.nearest(points)
    step = 1e-6
    numeric = np.stack([(visible.nearest(points + step * axis)[0] - distance) / step for axis in np.eye(3)], axis=1)
    error = np.linalg.norm(numeric - gradient, axis=1)
    # A few points lie where the nearest triangle changes.
    assert np.mean(error < 1e-3) > 0.95


def test_squash_makes_errors_along_the_view_cheap() -> None:
    eye = np.array([6.0, 0.0, 0.0])
    visible = build_surface(unit_box(), 4000, np.random.default_rng(0)).seen_from(eye, 0.1)
    along, _ = visible.nearest(np.array([[0.7, 0.0, 0.0]]))
    across, _ = visible.nearest(np.array([[0.5, 0.7, 0.0]]))
    np.testing.assert_allclose([along[0], across[0]], [0.02, 0.2], atol=1e-12)


def test_samples_stay_uniform_in_squashed_space() -> None:
    # Seen along a diagonal, top and front of a box shrink alike; seen along x, the sides shrink and thin out.
    surface = build_surface(unit_box(), 60_000, np.random.default_rng(0))
    visible = surface.seen_from(np.array([50.0, 5.0, 0.0]), 0.2)
    faces = visible._faces // 2
    counts = np.bincount(faces, minlength=6)
    seen = np.flatnonzero(counts)
    assert len(seen) == 2
    area = [np.linalg.norm(np.cross(*(visible._corners[2 * f, 1:] - visible._corners[2 * f, 0]))) for f in seen]
    np.testing.assert_allclose(counts[seen] / counts.sum(), np.array(area) / sum(area), atol=0.02)
