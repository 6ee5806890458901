"""Mean nearest distances against scipy's brute force and its tree, on moves and clouds of every kind."""

import numpy as np
import pytest
from scipy.spatial import KDTree
from scipy.spatial.distance import cdist

from tests.evaluation.pallet import nudge, random_motion, surface
from warehouse_sim.catalog.pallets import pallet
from warehouse_sim.evaluation.errors import nearest
from warehouse_sim.evaluation.errors.nearest import mean_nearest_distance
from warehouse_sim.evaluation.errors.visible_surface import depth_of, vsd
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.mesh import TriangleMesh, unit_box
from warehouse_sim.geometry.pose import make_transform, rotation_x, rotation_y, rotation_z, transform_points


def moves(count: int, angle: float, offset: float) -> np.ndarray:
    rng = np.random.default_rng(2)
    return np.stack([random_motion(rng, angle, offset) for _ in range(count)])


def by_force(T: np.ndarray, points: np.ndarray) -> np.ndarray:
    return np.array([cdist(transform_points(move, points), points).min(axis=1).mean() for move in T])


def clustered() -> np.ndarray:
    """A coarse surface with a line of very many points, some twice, as printed cartons have."""
    line = np.column_stack([np.linspace(0, 0.01, 300), np.full(300, 0.4), np.zeros(300)])
    return np.concatenate([surface(), line, line[:40]])


@pytest.mark.parametrize(
    ("T", "points"),
    [
        (moves(60, 0.05, 0.05), surface()),
        (moves(20, 0.05, 0.05), clustered()),
        (moves(40, np.pi, 3.0), surface()),
        (np.concatenate([moves(20, 0.02, 0.02), moves(2, np.pi, 50.0)]), surface()),
        (np.tile(np.eye(4), (30, 1, 1)), surface()),
        (moves(40, 0.1, 0.1), surface() * [1.0, 1.0, 0.0]),
        (moves(40, 0.1, 0.1), np.array([[0.1, 0.2, 0.3]])),
        (np.stack([nudge(z=1.0)] * 20), surface()),
        # So far away that every point may be the nearest to something in each cube: none is prepared.
        (moves(40, 0.0, 2.0) @ nudge(z=300.0), np.random.default_rng(4).random((700, 3))),
    ],
)
def test_cubes_find_what_force_finds(monkeypatch, T, points):
    expected = by_force(T, points)
    assert mean_nearest_distance(T, points, KDTree(points)) == pytest.approx(expected, rel=1e-6, abs=1e-8)
    monkeypatch.setattr(nearest, "_FEW", 0)
    monkeypatch.setattr(nearest, "_MOST_ALONG", 20)
    for worth in (0, 4):  # 0: every cube of the block is prepared
        monkeypatch.setattr(nearest, "_WORTH", worth)
        assert mean_nearest_distance(T, points, KDTree(points)) == pytest.approx(expected, rel=1e-6, abs=1e-8)


def test_the_tree_is_hardly_requested_when_moves_are_alike(monkeypatch):
    T, points = moves(300, 0.005, 0.005), surface()
    monkeypatch.setattr(nearest, "_FEW", 0)
    evaluated = []
    distances = nearest._Candidates.distances

    def watch(self, T, points):
        evaluated.append((self.cubes[self.block.number(self.block.places(T, points)), 2] == 0).mean())
        return distances(self, T, points)

    monkeypatch.setattr(nearest._Candidates, "distances", watch)
    mean_nearest_distance(T, points, KDTree(points))
    assert np.mean(evaluated) < 0.2


# Depth images by projection against exact rays.


CAMERA = PinholeCamera(48, 36, 42.0, 44.4, 22.3, 19.1)


def by_rays(mesh: TriangleMesh, T: np.ndarray, camera: PinholeCamera) -> np.ndarray:
    """Return the depth of the first triangle that each pixel's ray meets, ray by ray (Moeller-Trumbore)."""
    a, b, c = np.swapaxes((mesh.vertices @ T[:3, :3].T + T[:3, 3])[mesh.faces], 0, 1)
    found = np.zeros((camera.height, camera.width))
    for v in range(camera.height):
        for u in range(camera.width):
            ray = np.array([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0])
            p = np.cross(ray, c - a)
            det = ((b - a) * p).sum(axis=1)
            with np.errstate(divide="ignore", invalid="ignore"):
                s = (-a * p).sum(axis=1) / det
                q = np.cross(-a, b - a)
                t = (q @ ray) / det
                z = (q * (c - a)).sum(axis=1) / det
            z = z[(np.abs(det) > 1e-14) & (s >= 0) & (t >= 0) & (s + t <= 1) & (z > 0.01)]
            found[v, u] = z.min() if len(z) else 0.0
    return found


@pytest.mark.parametrize(
    ("place", "turn"),
    [
        ((0.2, 0.1, 2.5), rotation_z(0.4) @ rotation_x(1.1)),
        ((-1.3, 0.3, 2.0), rotation_y(0.7)),  # over the border
        ((0.1, 0.2, 0.4), rotation_x(0.3)),  # partly behind the camera
        ((0.0, 0.0, -2.0), np.eye(3)),  # all of it
    ],
)
@pytest.mark.parametrize("mesh", [pallet("epal1").mesh(), unit_box()], ids=["epal1", "box"])
def test_depth_is_that_of_rays_through_pixel_centres(mesh: TriangleMesh, place, turn) -> None:
    T = make_transform(turn, np.array(place))
    sampled, exact = depth_of(mesh, T, CAMERA), by_rays(mesh, T, CAMERA)
    differ = (sampled > 0) != (exact > 0)
    assert differ.mean() < 2e-3  # rays along an edge
    both = (sampled > 0) & (exact > 0)
    assert both.any() == (place[2] > 0)
    assert np.abs(sampled - exact)[both & ~differ].max(initial=0.0) < 1e-6


def test_a_plate_covers_the_pixels_whose_centres_it_covers() -> None:
    half = 10.5 * 2.0 / 70.0
    corners = np.array([[-half, -half, 0.0], [half, -half, 0.0], [half, half, 0.0], [-half, half, 0.0]])
    plate = TriangleMesh(corners, np.array([[0, 1, 2], [0, 2, 3]]))
    camera = PinholeCamera(80, 60, 70.0, 70.0, 40.0, 30.0)
    sampled = depth_of(plate, make_transform(None, np.array([0.0, 0.0, 2.0])), camera)
    assert (sampled > 0).sum() == 21 * 21
    assert sampled[20:41, 30:51] == pytest.approx(2.0)


# VSD on images of a few pixels, whose rays have lengths that can be said with a pencil.


THREE_RAYS = PinholeCamera(3, 1, 1.0, 1.0, 1.0, 0.0)
"""Its rays to z = 1 are as long as the square root of 2, 1 and the square root of 2."""
UNKNOWN = np.zeros((1, 3))


def depth(*values: float) -> np.ndarray:
    return np.array([values])


def test_surfaces_lie_apart_along_the_ray() -> None:
    # 0.9 m along the axis are 1.27 m along the outer rays: 9 % and 13 % of the diameter.
    found = vsd(depth(1.9, 1.9, 1.9), depth(1.0, 1.0, 1.0), UNKNOWN, THREE_RAYS, 10.0, taus=(0.05, 0.1, 0.15))
    assert found == pytest.approx([1.0, 2 / 3, 0.0])


def test_what_stands_before_a_surface_hides_it_along_the_ray() -> None:
    # 12 mm before it along the axis are 17 mm along the outer rays, which is more than the tolerance of 15 mm.
    true, seen = depth(1.0, 1.0, 1.0), depth(0.988, 0.988, 0.988)
    assert vsd(depth(0.0, 5.0, 0.0), true, seen, THREE_RAYS, 1.0, taus=(0.1,)) == pytest.approx([1.0])
    assert vsd(depth(1.0, 1.0, 1.0), true, seen, THREE_RAYS, 1.0, taus=(0.1,)) == pytest.approx([0.0])
    assert vsd(depth(0.98, 1.0, 0.0), true, seen, THREE_RAYS, 1.0, taus=(0.1,)) == pytest.approx([1 / 2])


def test_pixels_of_one_surface_alone_are_wrong() -> None:
    found = vsd(depth(1.0, 1.0, 0.0), depth(0.0, 1.0, 1.0), UNKNOWN, THREE_RAYS, 1.0, taus=(0.1,))
    assert found == pytest.approx([2 / 3])
    assert vsd(UNKNOWN, UNKNOWN, UNKNOWN, THREE_RAYS, 1.0) == pytest.approx(np.ones(10))
