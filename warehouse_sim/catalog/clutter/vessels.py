"""What things are thrown into or carried in: wheeled bins, buckets, canisters, plastic crates."""

from itertools import pairwise

import numpy as np

from warehouse_sim.catalog.parts import box_part, mesh_part, solid_box, solid_part
from warehouse_sim.catalog.traffic.shapes import assembled, rod, wheel
from warehouse_sim.geometry.solids import lathe, prism, superellipsoid
from warehouse_sim.schema import ObjectModel


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
