import numpy as np
import pytest

from tests.dataset.toy import PALLET
from warehouse_sim.estimators.pose.icp.surface import CadSurface, build_surface
from warehouse_sim.estimators.pose.icp.visible_surface import VisibleSurfaces
from warehouse_sim.geometry.mesh import unit_box

SURFACE = build_surface(PALLET.mesh(), 6000, np.random.default_rng(0))
BOX = build_surface(unit_box(), 4000, np.random.default_rng(0))


def seen(surface: CadSurface, eye: list[float], anisotropy: float) -> VisibleSurfaces:
    return VisibleSurfaces([surface], np.array([eye]), np.array([anisotropy]))


def test_distance_before_a_face_is_signed_and_along_its_normal() -> None:
    distance, direction = seen(BOX, [5.0, 0, 0], 1.0).nearest(np.array([[[0.7, 0.1, -0.2], [0.45, 0.3, 0.1]]]))
    np.testing.assert_allclose(distance[0], [0.2, -0.05], atol=1e-12)
    np.testing.assert_allclose(direction[0], [[1, 0, 0]] * 2, atol=1e-12)


def test_distance_beside_a_face_grows_away_from_its_edge() -> None:
    distance, direction = seen(BOX, [5.0, 0, 0], 1.0).nearest(np.array([[[0.5, 0.8, 0.0]]]))
    np.testing.assert_allclose(distance[0], [0.3], atol=1e-12)
    np.testing.assert_allclose(direction[0], [[0, 1, 0]], atol=1e-12)


@pytest.mark.parametrize("anisotropy", [1.0, 0.2])
def test_gradient_of_the_scaled_distance(anisotropy: float) -> None:
    visible = seen(SURFACE, [4.0, 1.5, 0.8], anisotropy)
    rng = np.random.default_rng(3)
    points = SURFACE.points[rng.integers(0, len(SURFACE.points), 200)] + rng.normal(0, 0.02, (200, 3))
    distance, gradient = visible.nearest(points[None])
    step = 1e-6
    moved = [visible.nearest(points[None] + step * axis)[0][0] for axis in np.eye(3)]
    numeric = np.stack([(there - distance[0]) / step for there in moved], axis=1)
    error = np.linalg.norm(numeric - gradient[0], axis=1)
    # A few points lie where the nearest triangle changes.
    assert np.mean(error < 1e-3) > 0.95


def test_anisotropy_makes_errors_along_the_view_cheap() -> None:
    distance, _ = seen(BOX, [6.0, 0.0, 0.0], 0.1).nearest(np.array([[[0.7, 0.0, 0.0], [0.5, 0.7, 0.0]]]))
    np.testing.assert_allclose(distance[0], [0.02, 0.2], atol=1e-12)


def test_objects_of_a_batch_see_their_own_surface_only() -> None:
    eyes, anisotropy = np.array([[5.0, 0, 0], [4.0, 1.5, 0.8]]), np.array([1.0, 0.3])
    points = np.random.default_rng(4).uniform(-1, 1, (2, 50, 3))
    distance, direction = VisibleSurfaces([BOX, SURFACE], eyes, anisotropy).nearest(points)
    for i, surface in enumerate((BOX, SURFACE)):
        alone = VisibleSurfaces([surface], eyes[i : i + 1], anisotropy[i : i + 1]).nearest(points[i : i + 1])
        np.testing.assert_allclose(distance[i], alone[0][0], atol=1e-9)
        np.testing.assert_allclose(direction[i], alone[1][0], atol=1e-6)


def test_from_inside_an_object_there_is_still_an_answer() -> None:
    distance, _ = seen(BOX, [0.01, 0.02, 0.0], 0.5).nearest(np.zeros((1, 3, 3)))
    assert np.isfinite(distance).all()


def test_samples_stay_uniform_in_scaled_space() -> None:
    # Seen along a diagonal, top and front of a box shrink alike; seen along x, the sides shrink and thin out.
    surface = build_surface(unit_box(), 60_000, np.random.default_rng(0))
    visible = seen(surface, [50.0, 5.0, 0.0], 0.2)
    counts = np.bincount(visible.faces // 2, minlength=6)
    sides = np.flatnonzero(counts)
    assert len(sides) == 2
    area = [np.linalg.norm(np.cross(*(visible.corners[2 * f, 1:] - visible.corners[2 * f, 0]))) for f in sides]
    np.testing.assert_allclose(counts[sides] / counts.sum(), np.array(area) / sum(area), atol=0.02)
