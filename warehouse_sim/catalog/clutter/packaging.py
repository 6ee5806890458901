"""What packing leaves behind: rolls of film and strap, flattened and open cartons, scraps of wood, torn film."""

from itertools import pairwise

import numpy as np

from warehouse_sim.catalog.parts import box_part, mesh_part, solid_box, solid_part
from warehouse_sim.catalog.traffic.shapes import assembled, rod
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import make_transform, rotation_x, rotation_y, rotation_z
from warehouse_sim.geometry.solids import lathe, superellipsoid, unit_cylinder, unit_tube
from warehouse_sim.schema import ObjectModel, Part

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
