"""What plastic pallets are moulded of: open grid decks, ribbed blocks, and feet that nest.

All are cached, so that pallets share the meshes; faces look outwards.
"""

from functools import cache

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.geometry.mesh import TriangleMesh


def lattice_solid(
    x: Float[np.ndarray, " a"],
    y: Float[np.ndarray, " b"],
    z: Float[np.ndarray, " c"],
    filled: Bool[np.ndarray, "i j k"],
) -> TriangleMesh:
    """Return the surface of the filled cells, with no faces between two of them.

    Neighbours share their vertices, so the mesh is watertight as long as filled cells do not touch along an edge only.

    Args:
        x: Grid planes along x (m), rising.
        y: Grid planes along y (m), rising.
        z: Grid planes along z (m), rising.
        filled: Which cells are solid; one less than the planes along each axis.
    """
    shape = (len(x), len(y), len(z))
    padded = np.pad(filled, 1)
    quads = []
    for axis in range(3):
        first, second = (axis + 1) % 3, (axis + 2) % 3
        for sign in (-1, 1):
            outside = ~np.roll(padded, -sign, axis)[1:-1, 1:-1, 1:-1]
            corner = np.argwhere(filled & outside)
            corner[:, axis] += sign > 0
            u, v = np.eye(3, dtype=int)[[first, second]]
            ring = np.stack([corner, corner + u, corner + u + v, corner + v], axis=1)
            quads.append(ring if sign > 0 else ring[:, ::-1])
    index = np.ravel_multi_index(np.moveaxis(np.concatenate(quads), -1, 0), shape)
    used, faces = np.unique(index[:, [0, 1, 2, 0, 2, 3]], return_inverse=True)
    i, j, k = np.unravel_index(used, shape)
    return TriangleMesh(np.column_stack([x[i], y[j], z[k]]), faces.reshape(-1, 3).astype(np.int32))


Rectangle = tuple[float, float, float, float]
"""Centre x, centre y, edge along x, edge along y (m)."""

_CORNER_STEPS = 3


@cache
def grid_deck(
    length: float,
    width: float,
    thickness: float,
    holes: tuple[int, int],
    rib: float,
    border: float,
    solid: tuple[Rectangle, ...] = (),
    open_: tuple[Rectangle, ...] = (),
) -> TriangleMesh:
    """Return a plate with a grid of square holes, centred on its bounding box.

    Args:
        length: Edge along x (m).
        width: Edge along y (m).
        thickness: Edge along z (m).
        holes: How many holes lie along x and along y.
        rib: Width of the ribs between holes (m).
        border: Width of the closed border (m).
        solid: Where the plate is closed: every hole that such a rectangle touches is left out.
        open_: Larger holes, each as wide as its rectangle; the holes that it touches are left out first.
    """
    columns, rows = _hole_edges(length, holes[0], rib, border), _hole_edges(width, holes[1], rib, border)
    x = np.unique(np.round([-length / 2, length / 2, *columns.ravel(), *_sides(open_, 0)], 9))
    y = np.unique(np.round([-width / 2, width / 2, *rows.ravel(), *_sides(open_, 1)], 9))
    u, v = (x[1:] + x[:-1]) / 2, (y[1:] + y[:-1]) / 2
    filled = np.ones((len(u), len(v)), dtype=bool)
    for left, right in columns:
        for low, high in rows:
            middle = ((left + right) / 2, (low + high) / 2, right - left, high - low)
            if not any(_touch(middle, rectangle) for rectangle in (*solid, *open_)):
                filled[np.ix_((u > left) & (u < right), (v > low) & (v < high))] = False
    for cx, cy, a, b in open_:
        filled[np.ix_(np.abs(u - cx) < a / 2, np.abs(v - cy) < b / 2)] = False
    return lattice_solid(x, y, np.array([-thickness / 2, thickness / 2]), filled[:, :, None])


@cache
def ribbed_block(length: float, width: float, height: float, pitch: float, rib: float, depth: float) -> TriangleMesh:
    """Return an upright whose four sides are recessed between vertical ribs, with closed plates above and below.

    Args:
        length: Edge along x (m).
        width: Edge along y (m).
        height: Edge along z (m).
        pitch: Greatest distance from rib to rib (m).
        rib: Width of a rib and thickness of the two plates (m).
        depth: Depth of the recesses (m), less than ``rib``.
    """
    x, is_rib_x = _ribs(length, pitch, rib, depth)
    y, is_rib_y = _ribs(width, pitch, rib, depth)
    z = np.array([-height / 2, rib - height / 2, height / 2 - rib, height / 2])
    u, v = (x[1:] + x[:-1]) / 2, (y[1:] + y[:-1]) / 2
    recess = (np.abs(u) > length / 2 - depth)[:, None] & ~is_rib_y | (np.abs(v) > width / 2 - depth) & ~is_rib_x[
        :, None
    ]
    filled = np.stack([np.ones_like(recess), ~recess, np.ones_like(recess)], axis=2)
    return lattice_solid(x, y, z, filled)


@cache
def nesting_foot(
    top: tuple[float, float], bottom: tuple[float, float], height: float, wall: float, radius: float
) -> TriangleMesh:
    """Return a hollow foot, open above and closed below, centred on its bounding box.

    Args:
        top: Outer edges along x and y at the open end (m).
        bottom: Outer edges along x and y on the ground (m).
        height: Height (m).
        wall: Thickness of the walls and the floor (m).
        radius: Radius of the upright edges (m).
    """
    thin = 2 * wall
    levels = [
        (bottom, -height / 2),
        (top, height / 2),
        ((top[0] - thin, top[1] - thin), height / 2),
        ((bottom[0] - thin, bottom[1] - thin), wall - height / 2),
    ]
    rings = np.stack([_rounded_rectangle(edges, z, radius) for edges, z in levels])
    count = rings.shape[1]
    index = np.arange(4 * count).reshape(4, count)
    follow = np.roll(index, -1, axis=1)
    band = [np.stack([index[i], follow[i], follow[i + 1], index[i + 1]], axis=1) for i in range(3)]
    quads = np.concatenate(band)
    fan = np.array([(0, i, i + 1) for i in range(1, count - 1)])
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]], fan[:, ::-1], fan + 3 * count])
    return TriangleMesh(rings.reshape(-1, 3), faces.astype(np.int32))


def _hole_edges(length: float, count: int, rib: float, border: float) -> Float[np.ndarray, "n 2"]:
    hole = (length - 2 * border - (count - 1) * rib) / count
    left = border - length / 2 + np.arange(count) * (hole + rib)
    return np.stack([left, left + hole], axis=1)


def _sides(rectangles: tuple[Rectangle, ...], axis: int) -> list[float]:
    return [item[axis] + sign * item[2 + axis] / 2 for item in rectangles for sign in (-1, 1)]


def _touch(a: Rectangle, b: Rectangle) -> bool:
    return abs(a[0] - b[0]) < (a[2] + b[2]) / 2 and abs(a[1] - b[1]) < (a[3] + b[3]) / 2


def _ribs(length: float, pitch: float, rib: float, depth: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the grid planes along one edge of a block, and which cells between them belong to a rib."""
    count = int(np.ceil((length - rib) / pitch))
    starts = np.linspace(-length / 2, length / 2 - rib, count + 1)
    cuts = [depth - length / 2, length / 2 - depth]
    planes = np.unique(np.round([*starts, *(starts + rib), *cuts], 9))
    middles = (planes[1:] + planes[:-1]) / 2
    return planes, np.any((middles[:, None] > starts) & (middles[:, None] < starts + rib), axis=1)


def _rounded_rectangle(edges: tuple[float, float], z: float, radius: float) -> Float[np.ndarray, "n 3"]:
    """Return the outline, counter-clockwise from above; a half turn about z maps it onto itself exactly."""
    angles = np.linspace(0.0, np.pi / 2, _CORNER_STEPS + 1)
    x, y = edges[0] / 2 - radius * (1 - np.cos(angles)), edges[1] / 2 - radius * (1 - np.sin(angles))
    first = np.column_stack([x, y])
    second = np.column_stack([-x, y])[::-1]
    half = np.concatenate([first, second])
    outline = np.concatenate([half, -half])
    return np.column_stack([outline, np.full(len(outline), z)])
