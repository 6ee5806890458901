"""Small things that stand about in halls and mean nothing: bins, buckets, tools, rolls, scraps, flattened cartons.

Sizes are those of common products. Origin at the centre of the bounding box, z up; all stand on their lowest faces.
"""

from itertools import pairwise

import numpy as np

from warehouse_sim.catalog.parts import box_part, mesh_part, solid_box, solid_part
from warehouse_sim.catalog.traffic.shapes import assembled, rod, wheel
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import make_transform, rotation_x, rotation_y, rotation_z
from warehouse_sim.geometry.solids import lathe, prism, superellipsoid, unit_cylinder, unit_tube
from warehouse_sim.schema import ObjectModel, Part


def waste_bin(name: str = "waste_bin") -> ObjectModel:
    """Build a wheeled bin of 120 l (EN 840-1): a tapered body, a lid that overhangs, two wheels and a handle."""
    parts = []
    for low, high, length, width in ((0.0, 0.3, 0.36, 0.37), (0.3, 0.6, 0.40, 0.41), (0.6, 0.87, 0.44, 0.45)):
        parts.append(box_part((length, width, high - low), (0.02, 0.0, (low + high) / 2), "plastic_grey"))
    parts.append(box_part((0.50, 0.48, 0.05), (0.0, 0.0, 0.895), "plastic_blue"))
    parts += [solid_part(superellipsoid(6.0, 3.0), (0.48, 0.46, 0.06), (0.0, 0.0, 0.915), "plastic_blue")]
    for side in (-1.0, 1.0):
        parts += wheel((-0.17, side * 0.215, 0.1), 0.2, 0.05, "plastic_black")
    parts.append(mesh_part(rod((-0.265, -0.2, 0.86), (-0.265, 0.2, 0.86), 0.014), "plastic_black"))
    solids = [solid_box((0.45, 0.46, 0.87), (0.02, 0.0, 0.435)), solid_box((0.54, 0.48, 0.08), (-0.02, 0.0, 0.9))]
    return assembled(name, "clutter", 900, parts, solids, 10.0)


def bucket(name: str = "bucket") -> ObjectModel:
    """Build a mop bucket of 12 l: a tapered shell with a rim, its handle down on one side."""
    shell = (
        (0.0, 0.0),
        (0.105, 0.0),
        (0.145, 0.27),
        (0.152, 0.27),
        (0.152, 0.285),
        (0.139, 0.285),
        (0.100, 0.006),
        (0.0, 0.006),
    )
    angle = np.linspace(-np.pi / 2, np.pi / 2, 13)
    path = np.column_stack([0.158 * np.cos(angle), 0.158 * np.sin(angle), 0.262 - 0.05 * np.cos(angle)])
    parts = [mesh_part(lathe(shell, 24), "plastic_red")]
    parts += [mesh_part(rod(a, b, 0.004, 8), "galvanised") for a, b in pairwise(path)]
    return assembled(name, "clutter", 901, parts, [solid_box((0.3, 0.3, 0.285), (0.0, 0.0, 0.1425))], 0.9)


def canister(name: str = "canister") -> ObjectModel:
    """Build a jerrycan of 20 l with a handle and a cap."""
    parts = [
        solid_part(superellipsoid(8.0, 10.0), (0.29, 0.25, 0.34), (0.0, 0.0, 0.17), "plastic_blue"),
        box_part((0.16, 0.035, 0.03), (-0.02, 0.0, 0.385), "plastic_blue"),
        *(box_part((0.03, 0.035, 0.06), (x, 0.0, 0.35), "plastic_blue") for x in (-0.085, 0.045)),
        mesh_part(lathe(((0.0, 0.33), (0.03, 0.33), (0.03, 0.375), (0.0, 0.375)), 16), "plastic_red"),
    ]
    parts[-1] = mesh_part(parts[-1].mesh, "plastic_red", (0.1, 0.0, 0.0))
    solids = [solid_box((0.29, 0.25, 0.34), (0.0, 0.0, 0.17)), solid_box((0.23, 0.06, 0.06), (0.015, 0.0, 0.37))]
    return assembled(name, "clutter", 902, parts, solids, 21.0)


def pallet_box(name: str = "pallet_box") -> ObjectModel:
    """Build an open crate of boards with three things of steel left in it: two bars and a coil."""
    length, width, height, board = 0.6, 0.4, 0.3, 0.015
    parts = [box_part((length, width, board), (0.0, 0.0, board / 2), "pallet_wood_tan")]
    for level in range(3):
        z = board + (level + 0.5) * (height - board) / 3
        tall = (height - board) / 3 - 0.012
        parts += [box_part((length, board, tall), (0.0, s * (width - board) / 2, z), "pallet_wood") for s in (-1, 1)]
        parts += [
            box_part((board, width - 2 * board, tall), (s * (length - board) / 2, 0.0, z), "pallet_wood")
            for s in (-1, 1)
        ]
    for x, y in ((-1, -1), (-1, 1), (1, -1), (1, 1)):
        at = (x * (length / 2 - 0.035), y * (width / 2 - 0.035), height / 2)
        parts.append(box_part((0.04, 0.04, height - 0.002), at, "pallet_wood_grey"))
    coil = prism(tuple((0.11 * float(np.cos(a)), 0.11 * float(np.sin(a))) for a in np.arange(20) * np.pi / 10), 0.06)
    parts.append(mesh_part(coil, "steel_paint_black", (0.1, 0.0, board + 0.03)))
    parts += [box_part((0.05, 0.3, 0.05), (-0.15 + k * 0.08, 0.0, board + 0.025), "fork_steel") for k in (0, 1)]
    return assembled(name, "clutter", 903, parts, [solid_box((length, width, height), (0.0, 0.0, height / 2))], 14.0)


def toolbox(name: str = "toolbox") -> ObjectModel:
    """Build a steel toolbox, 0.5 m long, with a lid, a bar to carry it by and two latches."""
    parts = [
        box_part((0.50, 0.22, 0.15), (0.0, 0.0, 0.075), "steel_paint_blue"),
        box_part((0.51, 0.23, 0.06), (0.0, 0.0, 0.18), "steel_paint_blue"),
        *(box_part((0.02, 0.02, 0.05), (x, 0.0, 0.235), "steel_paint_black") for x in (-0.16, 0.16)),
        mesh_part(rod((-0.17, 0.0, 0.262), (0.17, 0.0, 0.262), 0.012), "steel_paint_black"),
        *(box_part((0.05, 0.006, 0.05), (x, 0.115, 0.145), "chrome") for x in (-0.14, 0.14)),
    ]
    solids = [solid_box((0.51, 0.236, 0.21), (0.0, 0.0, 0.105)), solid_box((0.34, 0.03, 0.07), (0.0, 0.0, 0.24))]
    return assembled(name, "clutter", 910, parts, solids, 9.0)


def broom(name: str = "broom") -> ObjectModel:
    """Build a hall broom that lies on the floor: a head of 0.6 m on its bristles' side and a stick of 1.4 m."""
    start, end = np.array([0.03, 0.0, 0.07]), np.array([1.42, 0.0, 0.013])
    parts = [
        box_part((0.05, 0.60, 0.045), (0.0, 0.0, 0.0925), "pallet_wood_tan"),
        box_part((0.07, 0.58, 0.07), (0.0, 0.0, 0.035), "plastic_red"),
        mesh_part(rod(start, end, 0.0125), "pallet_wood_new"),
    ]
    step = end - start
    turn = rotation_y(float(np.arctan2(-step[2], step[0])))
    stick = OrientedBox(make_transform(turn, (start + end) / 2), np.array([float(np.linalg.norm(step)), 0.025, 0.025]))
    return assembled(name, "clutter", 911, parts, [solid_box((0.07, 0.60, 0.115), (0.0, 0.0, 0.0575)), stick], 1.6)


def step_ladder(name: str = "step_ladder") -> ObjectModel:
    """Build a folding ladder of five treads that stands open, 1.3 m high."""
    height, spread, width = 1.3, 0.42, 0.46
    parts, solids = [], []
    for x, material in ((-1.0, "galvanised"), (1.0, "galvanised")):
        for y in (-1.0, 1.0):
            foot, top = np.array([x * spread, y * width / 2, 0.0]), np.array([x * 0.05, y * width * 0.42, height])
            turn = _towards(top - foot)
            size = np.array([0.05, 0.025, float(np.linalg.norm(top - foot)) - 0.03])
            middle = (foot + top) / 2 + np.array([0.0, 0.0, 0.005])
            parts.append(box_part(size, middle, material, turn))
            solids.append(OrientedBox(make_transform(turn, middle), size))
    for number in range(1, 6):
        fraction = number / 5.0
        x, z = -spread + fraction * (spread - 0.05), fraction * (height - 0.02)
        tread = (0.085 if number < 5 else 0.24, width * (1.0 - 0.16 * fraction) - 0.02, 0.03)
        at = (x if number < 5 else 0.0, 0.0, z)
        parts.append(box_part(tread, at, "plastic_red" if number == 5 else "galvanised"))
        solids.append(solid_box(tread, at))
    parts += [box_part((0.03, width, 0.03), (0.36 * spread / 0.42, 0.0, 0.25), "galvanised")]
    return assembled(name, "clutter", 912, parts, solids, 7.0)


def hand_truck(name: str = "hand_truck") -> ObjectModel:
    """Build a sack truck that stands on its toe plate and two wheels, 1.15 m high."""
    parts = [box_part((0.22, 0.40, 0.008), (0.11, 0.0, 0.004), "steel_paint_blue")]
    for side in (-1.0, 1.0):
        parts.append(mesh_part(rod((0.0, side * 0.19, 0.0), (-0.04, side * 0.19, 1.05), 0.014), "steel_paint_blue"))
        parts.append(mesh_part(rod((-0.04, side * 0.19, 1.05), (-0.16, side * 0.19, 1.15), 0.016), "rubber"))
        parts += wheel((-0.13, side * 0.25, 0.13), 0.26, 0.07, "plastic_red")
        parts.append(mesh_part(rod((-0.01, side * 0.19, 0.3), (-0.13, side * 0.19, 0.13), 0.01), "steel_paint_blue"))
    parts += [
        mesh_part(rod((-0.01 - 0.04 * z, -0.19, z), (-0.01 - 0.04 * z, 0.19, z), 0.011), "steel_paint_blue")
        for z in (0.3, 0.6, 0.9)
    ]
    parts.append(mesh_part(rod((-0.13, -0.25, 0.13), (-0.13, 0.25, 0.13), 0.01), "fork_steel"))
    solids = [
        solid_box((0.22, 0.40, 0.01), (0.11, 0.0, 0.005)),
        solid_box((0.26, 0.58, 0.26), (-0.13, 0.0, 0.13)),
        solid_box((0.07, 0.42, 1.05), (-0.02, 0.0, 0.525)),
        solid_box((0.15, 0.42, 0.13), (-0.1, 0.0, 1.09)),
    ]
    return assembled(name, "clutter", 913, parts, solids, 9.0)


def extension_reel(name: str = "extension_reel") -> ObjectModel:
    """Build a cable reel on a bent frame of tube, 0.36 m high."""
    across = rotation_x(np.pi / 2)
    parts = [
        solid_part(unit_tube(0.5, 24), (0.24, 0.24, 0.09), (0.0, 0.0, 0.19), "cone_orange", across),
        *(
            solid_part(unit_cylinder(24), (0.28, 0.28, 0.012), (0.0, y, 0.19), "plastic_black", across)
            for y in (-0.055, 0.055)
        ),
        *(
            mesh_part(rod((x, y, 0.01), (0.0, y, 0.345), 0.01, 8), "steel_paint_black")
            for x in (-0.13, 0.13)
            for y in (-0.08, 0.08)
        ),
        mesh_part(rod((0.0, -0.09, 0.345), (0.0, 0.09, 0.345), 0.014, 8), "plastic_black"),
        *(mesh_part(rod((x, -0.09, 0.01), (x, 0.09, 0.01), 0.01, 8), "steel_paint_black") for x in (-0.13, 0.13)),
    ]
    return assembled(name, "clutter", 914, parts, [solid_box((0.30, 0.19, 0.36), (0.0, 0.0, 0.18))], 6.0)


def _towards(way: np.ndarray) -> np.ndarray:
    """Return a rotation whose z axis runs along ``way``."""
    z = way / np.linalg.norm(way)
    y = np.cross(z, [1.0, 0.0, 0.0])
    y /= np.linalg.norm(y)
    return np.column_stack([np.cross(y, z), y, z])


_BOARD = 0.005
"""Thickness of corrugated board (m)."""


def film_roll(name: str = "film_roll") -> ObjectModel:
    """Build a roll of machine film, 0.5 m wide, that stands on end on its core of board."""
    parts, solid = _roll(0.0, 0.0, 0.24, 0.5)
    return assembled(name, "clutter", 920, parts, [solid], 16.0, turns=4)


def film_rolls(name: str = "film_rolls") -> ObjectModel:
    """Build five rolls of hand film that stand together, some used up half."""
    parts: list[Part] = []
    solids = []
    for x, y, width in (
        (-0.09, -0.07, 0.125),
        (0.05, -0.08, 0.12),
        (-0.10, 0.07, 0.09),
        (0.04, 0.06, 0.125),
        (0.17, 0.01, 0.08),
    ):
        pieces, solid = _roll(x, y, width, 0.5)
        parts += pieces
        solids.append(solid)
    return assembled(name, "clutter", 921, parts, solids, 9.0)


def strap_roll(name: str = "strap_roll") -> ObjectModel:
    """Build a coil of strapping that lies flat, its loose end up in the air."""
    end = np.array([[0.19, -0.05, 0.19], [0.24, 0.06, 0.20], [0.25, 0.17, 0.14], [0.22, 0.26, 0.03]])
    parts = [
        solid_part(unit_tube(0.55, 32), (0.40, 0.40, 0.16), (0.0, 0.0, 0.08), "strap"),
        solid_part(unit_tube(0.9, 24), (0.22, 0.22, 0.19), (0.0, 0.0, 0.095), "kraft_dark"),
        *(mesh_part(rod(a, b, 0.006, 8), "strap") for a, b in pairwise(end)),
    ]
    return assembled(name, "clutter", 922, parts, [solid_box((0.4, 0.4, 0.19), (0.0, 0.0, 0.095))], 12.0)


def flat_cartons(name: str = "flat_cartons") -> ObjectModel:
    """Build a pile of flattened cartons, each a little off the one below."""
    rng = np.random.default_rng(923)
    parts, z = [], 0.0
    for _ in range(14):
        size = np.array([rng.uniform(0.7, 1.0), rng.uniform(0.5, 0.7), 2 * _BOARD])
        at = np.array([rng.uniform(-0.05, 0.05), rng.uniform(-0.05, 0.05), z + _BOARD])
        board = ("kraft", "kraft_light", "kraft_dark", "board_white")[int(rng.integers(4))]
        parts.append(box_part(size, at, board, rotation_z(rng.normal(0.0, 0.06))))
        z += 2 * _BOARD + 0.0005
    return assembled(name, "clutter", 923, parts, [solid_box((0.95, 0.68, z), (0.0, 0.0, z / 2))], 9.0)


def open_carton(name: str = "open_carton") -> ObjectModel:
    """Build an empty carton of 500 x 400 x 300 mm whose four flaps stand open."""
    length, width, height = 0.5, 0.4, 0.3
    parts = [box_part((length, width, _BOARD), (0.0, 0.0, _BOARD / 2), "kraft")]
    solids = [solid_box((length, width, height), (0.0, 0.0, height / 2))]
    for axis, sign, lean in ((0, 1.0, 2.2), (0, -1.0, 1.9), (1, 1.0, 2.4), (1, -1.0, 0.7)):
        out, edge = (length, width)[axis] / 2, (width, length)[axis]
        wall = (_BOARD, edge, height) if axis == 0 else (edge - 2 * _BOARD, _BOARD, height)
        at = np.zeros(3)
        at[axis], at[2] = sign * (out - _BOARD / 2), height / 2
        parts.append(box_part(wall, at, "kraft"))
        flap = width / 2
        turn = (rotation_y(sign * lean) if axis == 0 else rotation_x(-sign * lean)) @ np.eye(3)
        hinge = np.zeros(3)
        hinge[axis], hinge[2] = sign * out, height
        middle = hinge + turn @ np.array([0.0, 0.0, flap / 2])
        size = np.array([_BOARD, edge - 0.01, flap] if axis == 0 else [edge - 0.01, _BOARD, flap])
        parts.append(box_part(size, middle, "kraft_light", turn))
        solids.append(OrientedBox(make_transform(turn, middle), size))
    return assembled(name, "clutter", 924, parts, solids, 0.7)


def wood_scraps(name: str = "wood_scraps") -> ObjectModel:
    """Build broken boards and blocks of pallets in a heap of three layers, each board level on those below."""
    rng = np.random.default_rng(925)
    parts = []
    for layer in range(3):
        for number in range(3):
            length = rng.uniform(0.4, 1.0)
            across = (number - 1) * 0.22 + rng.uniform(-0.03, 0.03)
            turn = rotation_z(layer * np.pi / 2 + rng.normal(0.0, 0.12))
            at = turn @ np.array([rng.uniform(-0.08, 0.08), across, 0.0]) + [0.0, 0.0, 0.011 + 0.022 * layer]
            wood = ("pallet_wood", "pallet_wood_grey", "pallet_wood_dark", "wood_broken")[int(rng.integers(4))]
            parts.append(box_part((length, 0.1, 0.022), at, wood, turn))
    parts += [
        box_part((0.145, 0.1, 0.078), (x, y, 0.066 + 0.039), "pallet_block") for x, y in ((0.05, 0.1), (-0.12, -0.05))
    ]
    return assembled(name, "clutter", 925, parts, [solid_box((0.9, 0.75, 0.144), (0.0, 0.0, 0.072))], 8.0)


def film_heap(name: str = "film_heap") -> ObjectModel:
    """Build a sack of torn film: a slack bag that is as good as white, its neck tied."""
    neck = lathe(((0.0, 0.38), (0.10, 0.38), (0.03, 0.46), (0.035, 0.50), (0.06, 0.55), (0.0, 0.55)), 16)
    parts = [
        solid_part(superellipsoid(2.8, 2.6, 48, 20), (0.62, 0.52, 0.42), (0.0, 0.0, 0.21), "sack_woven"),
        solid_part(superellipsoid(3.0, 2.2, 48, 16), (0.52, 0.58, 0.26), (0.02, 0.0, 0.13), "sack_woven"),
        solid_part(superellipsoid(2.4, 2.4, 32, 12), (0.30, 0.26, 0.22), (-0.16, 0.12, 0.30), "sack_woven"),
        mesh_part(neck, "sack_woven"),
        solid_part(unit_cylinder(16), (0.075, 0.075, 0.02), (0.0, 0.0, 0.47), "strap"),
    ]
    solids = [solid_box((0.60, 0.54, 0.40), (0.0, 0.0, 0.20)), solid_box((0.12, 0.12, 0.13), (0.0, 0.0, 0.485))]
    return assembled(name, "clutter", 926, parts, solids, 4.0)


def _roll(x: float, y: float, diameter: float, height: float) -> tuple[list[Part], OrientedBox]:
    """Return film on a core that stands out at both ends, and its box."""
    core = 0.6 * diameter if diameter < 0.1 else 0.08
    parts = [
        solid_part(
            unit_tube(core / diameter, 24), (diameter, diameter, height - 0.02), (x, y, height / 2), "plastic_white"
        ),
        solid_part(unit_tube(0.9, 16), (core, core, height), (x, y, height / 2), "kraft_dark"),
    ]
    return parts, solid_box((diameter, diameter, height), (x, y, height / 2))
