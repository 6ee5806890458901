"""Moulded pallets, on three runners or on nine feet that nest, as plans of numbers; x along the longer edge.

They consist of open grid decks, ribbed blocks and feet; meshes are cached and shared, and faces look outwards.

Sizes of ``RUNNERS`` follow stand.no 141 ("Specification for reusable 1/1 plastic pallet"): at most 18 kg, 144-151 mm
high; 800 mm face: opening at least 90 mm high, middle block at most 150 mm, at least 595 mm between the outer blocks;
1200 mm face: opening 100-103 mm high, middle block at most 150 mm, at least 900 mm between the outer ones.

``FEET`` is a light one-way pallet as sold at 1200 x 800 x 140 mm and 6 kg (comansa, 045494) or 5.6 kg
(Goplasticpallets, APB1208 LSO). Its feet keep the same clear widths. Unverified: thickness of the deck, pitch of the
grid, taper of the feet.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.catalog.pallets.pockets import Window, pallet_model, window_between
from warehouse_sim.catalog.parts import box_part, in_role, mesh_part, solid_box
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.schema import ObjectModel, Part


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


_HOLES, _RIB, _BORDER = (18, 12), 0.014, 0.024
_RIBS = (0.045, 0.009, 0.006)
_WALL, _FOOT_RADIUS = 0.004, 0.012


@dataclass(frozen=True)
class RunnerPallet:
    """The plan of a pallet on three runners; all lengths in m."""

    obj_id: int
    """Number of the geometry, fixed for ever."""
    length: float = 1.2
    """Edge along x."""
    width: float = 0.8
    """Edge along y."""
    height: float = 0.150
    """Height over all."""
    deck: float = 0.030
    """Thickness of the deck."""
    runner: float = 0.020
    """Thickness of a runner."""
    block: float = 0.145
    """Length of the blocks along x."""
    lanes: tuple[float, float] = (0.100, 0.145)
    """Widths of the outer lanes of blocks and of the middle one."""
    mass: float = 18.0
    """Kilograms."""


@dataclass(frozen=True)
class FootPallet:
    """The plan of a pallet on nine nesting feet; all lengths in m."""

    obj_id: int
    """Number of the geometry, fixed for ever."""
    length: float = 1.2
    """Edge along x."""
    width: float = 0.8
    """Edge along y."""
    height: float = 0.140
    """Height over all."""
    deck: float = 0.025
    """Thickness of the deck."""
    foot_top: tuple[float, float] = (0.140, 0.095)
    """Outer edges of a foot along x and y under the deck."""
    foot_bottom: tuple[float, float] = (0.105, 0.065)
    """Outer edges of a foot along x and y on the ground."""
    inset: float = 0.005
    """Distance of the outer feet from the pallet's sides."""
    mass: float = 6.0
    """Kilograms."""


RUNNERS, FEET = RunnerPallet(obj_id=8), FootPallet(obj_id=9)


def on_runners(plan: RunnerPallet, name: str, plastic: str) -> ObjectModel:
    """Return the pallet on three runners, of the material ``plastic``."""
    lanes = _lanes(plan)
    rows = [(x, y, width) for x in _middles(plan.length, plan.block) for y, width in lanes]
    above_blocks = tuple((x, y, plan.block, width) for x, y, width in rows)
    deck = grid_deck(plan.length, plan.width, plan.deck, _holes(plan), _RIB, _BORDER, solid=above_blocks)
    upright = plan.height - plan.deck - plan.runner
    block_z = plan.runner + (upright - plan.height) / 2
    deck_z, low = (plan.height - plan.deck) / 2, (plan.runner - plan.height) / 2
    parts = [mesh_part(deck, plastic, (0.0, 0.0, deck_z))]
    for x, y, width in rows:
        block = ribbed_block(plan.block, width, upright, *_RIBS)
        parts.append(mesh_part(block, plastic, (x, y, block_z)))
    parts += [box_part((plan.length, width, plan.runner), (0.0, y, low), plastic) for y, width in lanes]
    solids = [solid_box((plan.block, width, upright), (x, y, block_z)) for x, y, width in rows]
    solids += [solid_box((plan.length, width, plan.runner), (0.0, y, low)) for y, width in lanes]
    ends = window_between(*plan.lanes, plan.width, 0.0, plan.runner + upright)
    sides = window_between(plan.block, plan.block, plan.length, plan.runner, plan.runner + upright)
    return _moulded(name, plan, parts, solids, ends, sides)


def on_feet(plan: FootPallet, name: str, plastic: str) -> ObjectModel:
    """Return the pallet on nine nesting feet, of the material ``plastic``."""
    upright = plan.height - plan.deck
    (length, width), inset = plan.foot_top, plan.inset
    columns, lanes = _middles(plan.length - 2 * inset, length), _middles(plan.width - 2 * inset, width)
    places = [(x, y) for x in columns for y in lanes]
    mouths: tuple[Rectangle, ...] = tuple((x, y, length - 2 * _WALL, width - 2 * _WALL) for x, y in places)
    deck = grid_deck(plan.length, plan.width, plan.deck, _holes(plan), _RIB, _BORDER, open_=mouths)
    foot = nesting_foot(plan.foot_top, plan.foot_bottom, upright, _WALL, _FOOT_RADIUS)
    parts: list[Part] = [mesh_part(deck, plastic, (0.0, 0.0, (plan.height - plan.deck) / 2))]
    parts += [mesh_part(foot, plastic, (x, y, -plan.deck / 2)) for x, y in places]
    # The narrow end of a foot, so that no box is wider than the foot it stands for.
    solids: list[OrientedBox] = [solid_box((*plan.foot_bottom, upright), (x, y, -plan.deck / 2)) for x, y in places]
    ends = window_between(width + inset, width, plan.width, 0.0, upright)
    sides = window_between(length + inset, length, plan.length, 0.0, upright)
    return _moulded(name, plan, parts, solids, ends, sides)


def _moulded(
    name: str,
    plan: RunnerPallet | FootPallet,
    parts: list[Part],
    solids: list[OrientedBox],
    ends: Window,
    sides: Window,
) -> ObjectModel:
    """Return the pallet of these parts and uprights, with pockets on all sides."""
    plate = solid_box((plan.length, plan.width, plan.deck), (0.0, 0.0, (plan.height - plan.deck) / 2))
    size = np.array([plan.length, plan.width, plan.height])
    windows = {"-x": ends, "+x": ends, "-y": sides, "+y": sides}
    return pallet_model(name, plan.obj_id, plan.mass, size, in_role(parts, "moulded"), (plate, *solids), windows)


def _holes(plan: RunnerPallet | FootPallet) -> tuple[int, int]:
    """Return how many holes the deck has along x and y; their pitch is that of 18 x 12 on 1200 x 800 mm."""
    return round(_HOLES[0] * plan.length / 1.2), round(_HOLES[1] * plan.width / 0.8)


def _middles(length: float, outer: float) -> tuple[float, float, float]:
    """Return the centres of three rows of width ``outer`` (m): two flush with the ends of ``length``, one between."""
    edge = (length - outer) / 2
    return -edge, 0.0, edge


def _lanes(plan: RunnerPallet) -> list[tuple[float, float]]:
    """Return (y, width) of the three lanes of blocks."""
    outer, middle = plan.lanes
    return list(zip(_middles(plan.width, outer), (outer, middle, outer), strict=True))
