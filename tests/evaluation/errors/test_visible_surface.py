"""Depth images by projection against exact rays, and VSD against its definition."""

import numpy as np
import pytest

from warehouse_sim.catalog.pallets import pallet
from warehouse_sim.evaluation.errors.visible_surface import depth_of, vsd
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.mesh import TriangleMesh, unit_box
from warehouse_sim.geometry.pose import make_transform, rotation_x, rotation_y, rotation_z

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
