"""Rays into the openings of a box-shaped portal: open, blocked on one side, hidden."""

import numpy as np
import pytest

from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.pose.uncertainty.estimator import look_into
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.mesh import TriangleMesh, merge, unit_box
from warehouse_sim.geometry.pose import make_transform, rotation_z

CAMERA = PinholeCamera.from_focal(320, 200, 400.0)
# Object frame as a camera at 3 m looks along its x: camera z = object x, camera x = -object y, camera y = -object z.
AXES = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
T = make_transform(AXES, np.array([0.0, 0.0, 3.0]))


def box(low, high) -> TriangleMesh:
    low, high = np.array(low, dtype=float), np.array(high, dtype=float)
    return TriangleMesh(unit_box().vertices * (high - low) + (low + high) / 2, unit_box().faces)


# A deck on three walls: two openings 0.3 m wide and 0.2 m high, through and through.
WALLS = [
    box((-0.5, -0.45, 0.1), (0.5, 0.45, 0.15)),
    *(box((-0.5, y - 0.05, -0.1), (0.5, y + 0.05, 0.1)) for y in (-0.4, 0.0, 0.4)),
]
PORTAL = merge(WALLS)


def seen(*solids: TriangleMesh, noise: float = 0.0, wall: float = 6.0) -> RgbdImage:
    """Return an image by another road: each pixel's ray against each box by its slabs."""
    rays = CAMERA.rays().reshape(-1, 3)
    depth = np.full(len(rays), wall)
    for solid in solids:
        low, high = solid.vertices.min(axis=0), solid.vertices.max(axis=0)
        corners = np.array([low, high]) @ T[:3, :3].T + T[:3, 3]
        low, high = corners.min(axis=0), corners.max(axis=0)
        with np.errstate(divide="ignore"):
            one, other = low / rays, high / rays
        enter, leave = np.minimum(one, other).max(axis=1), np.maximum(one, other).min(axis=1)
        depth = np.where((leave > enter) & (enter > 0), np.minimum(depth, enter), depth)
    depth += noise * np.random.default_rng(1).standard_normal(len(depth))
    return RgbdImage(CAMERA, depth.reshape(200, 320).astype(np.float32), ())


LEFT = ((-0.4, 0.06, -0.1), (-0.1, 0.34, 0.08))


@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_open_openings_have_room(noise: float) -> None:
    room = look_into(T, PORTAL, seen(*WALLS, noise=noise), np.random.default_rng(0))
    assert min(room.rays) > 50
    assert max(room.ended) < 0.05 * min(room.rays)
    assert not room.blocked


@pytest.mark.parametrize(
    "thing", [LEFT, ((-0.9, 0.06, -0.1), (-0.6, 0.34, 0.08)), ((0.1, 0.06, -0.1), (0.3, 0.34, 0.1))]
)
def test_a_thing_in_one_opening_or_close_before_it_blocks(thing) -> None:
    room = look_into(T, PORTAL, seen(*WALLS, box(*thing), noise=0.01), np.random.default_rng(0))
    assert room.blocked
    # The other one is open.
    left, right = (ended / rays for ended, rays in zip(room.ended, room.rays, strict=True))
    assert max(left, right) > 0.6
    assert min(left, right) < 0.1


def test_what_hides_from_afar_blocks_nothing_and_what_is_not_seen_is_not_told() -> None:
    hidden = seen(*WALLS, box((-2.0, -0.45, -0.3), (-1.9, 0.45, 0.3)))
    room = look_into(T, PORTAL, hidden, np.random.default_rng(0))
    assert sum(room.rays) == 0
    assert not room.blocked
    nothing = RgbdImage(CAMERA, np.zeros((200, 320), dtype=np.float32), ())
    assert not look_into(T, PORTAL, nothing, np.random.default_rng(0)).blocked


def test_a_wall_where_openings_should_be_blocks() -> None:
    wall = box((-0.5, -0.45, -0.1), (0.5, 0.45, 0.15))
    assert look_into(T, PORTAL, seen(wall), np.random.default_rng(0)).blocked
    turned = T @ make_transform(rotation_z(np.pi), np.zeros(3))
    assert look_into(turned, PORTAL, seen(wall), np.random.default_rng(0)).blocked
