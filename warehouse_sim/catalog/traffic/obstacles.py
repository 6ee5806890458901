"""Small things that stand or hang in the way: cones, bollards, folding signs, film torn off a load.

Origin at the centre of the bounding box, z up.
"""

import numpy as np

from warehouse_sim.catalog.parts import box_part, mesh_part, solid_box, solid_part
from warehouse_sim.catalog.traffic.shapes import assembled, tube
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import make_transform, rotation_y
from warehouse_sim.geometry.solids import Outline, lathe, superellipsoid, unit_cylinder
from warehouse_sim.schema import ObjectModel, Part

CONES = {"cone_500": (179, 0.50, 0.29, 1.5), "cone_750": (180, 0.75, 0.39, 3.2)}
"""Catalog name -> obj_id, height (m), edge of the base (m), mass (kg); the sizes of EN 13422, 0.75 m indoors."""
WRAPS = {"hanging_wrap_short": (183, 0.8, 0.32), "hanging_wrap_long": (184, 1.5, 0.45)}
"""Catalog name -> obj_id, length and greatest width (m); film comes 450-500 mm wide and ropes together as it tears."""

FINE_CONES = {"traffic_cone_500": (586, "cone_500"), "traffic_cone_750": (587, "cone_750")}
"""Catalog name of a finely divided cone -> obj_id, the coarse one of its size."""

_FILM = 0.0006  # some 20-30 layers of 20 um film roped together


def cone(name: str) -> ObjectModel:
    """Build a traffic cone with two reflective bands on a square rubber base."""
    return _cone(name, *CONES[name], 24)


def traffic_cone(name: str) -> ObjectModel:
    """Build a traffic cone as ``cone`` does, of 72 sides, with a rounded top and a rim around its foot."""
    obj_id, coarse = FINE_CONES[name]
    return _cone(name, obj_id, *CONES[coarse][1:], 72)


def _cone(name: str, obj_id: int, height: float, base: float, mass: float, sides: int) -> ObjectModel:
    """Build a cone of ``height`` on a base of edge ``base`` (m)."""
    foot, lower, upper = 0.05 * height, 0.36 * base, 0.075 * base
    slope = (upper - lower) / (height - foot)

    def radius(z: float) -> float:
        return lower + slope * (z - foot)

    profile: Outline = ((0.0, foot), (lower, foot), (upper, height), (0.0, height))
    if sides > 24:
        rim, lip = foot + 0.012, 0.25 * upper
        top = ((upper, height - 0.012), (upper - 0.004, height - 0.003), (upper - lip, height))
        bore = ((upper - lip - 0.002, height - 0.03), (0.0, height - 0.03))
        profile = (
            (0.0, foot),
            (lower + 0.02, foot),
            (lower + 0.02, rim),
            (radius(rim + 0.01), rim + 0.01),
            *top,
            *bore,
        )
    body = lathe(profile, sides)
    parts = [mesh_part(body, "cone_orange")]
    for low, high in ((0.38, 0.55), (0.70, 0.82)):
        a, b, standoff = low * height, high * height, 0.002
        ring = lathe(((0.0, a), (radius(a) + standoff, a), (radius(b) + standoff, b), (0.0, b)), sides)
        parts.append(mesh_part(ring, "reflective"))
    corner = superellipsoid(6.0, 8.0, sides, 4)
    parts.append(solid_part(corner, (base, base, foot), (0.0, 0.0, foot / 2), "mast_black"))
    solids = [solid_box((base, base, foot), (0.0, 0.0, foot / 2))]
    for low, high in ((foot, 0.4 * height), (0.4 * height, 0.7 * height), (0.7 * height, height)):
        width = 2 * radius(low) + 0.004
        solids.append(solid_box((width, width, high - low), (0.0, 0.0, (low + high) / 2)))
    return assembled(name, "cone", obj_id, parts, solids, mass, turns=4)


def bollard(name: str = "bollard") -> ObjectModel:
    """Build a steel bollard: a tube of 159 mm, 1.2 m high, yellow with black bands, on a base plate."""
    diameter, height, plate, bands = 0.159, 1.2, 0.012, 6
    parts: list[Part] = [box_part((0.25, 0.25, plate), (0.0, 0.0, plate / 2), "guard_black")]
    step = (height - plate - 0.03) / bands
    for index in range(bands):
        paint = "guard_yellow" if index % 2 else "guard_black"
        at = (0.0, 0.0, plate + (index + 0.5) * step)
        parts.append(solid_part(unit_cylinder(24), (diameter, diameter, step), at, paint))
    cap = lathe(((0.0, 0.0), (diameter / 2, 0.0), (0.055, 0.02), (0.0, 0.03)), 24)
    parts.append(mesh_part(cap, "guard_yellow", (0.0, 0.0, height - 0.03)))
    solids = [solid_box((0.25, 0.25, plate), (0.0, 0.0, plate / 2))]
    solids.append(solid_box((diameter, diameter, height - plate), (0.0, 0.0, (height + plate) / 2)))
    return assembled(name, "bollard", 181, parts, solids, 21.0, turns=4)


def floor_sign(name: str = "floor_sign") -> ObjectModel:
    """Build a folding "wet floor" sign: two yellow boards that lean together, 0.6 m high, with a printed triangle."""
    parts: list[Part] = []
    solids: list[OrientedBox] = []
    lean, height, width, sheet = np.deg2rad(14.0), 0.60, 0.29, 0.012
    for side in (-1.0, 1.0):
        turn = rotation_y(-side * lean)
        middle = np.array([side * np.sin(lean) * height / 2, 0.0, np.cos(lean) * height / 2 + 0.002])
        out = turn @ np.array([side, 0.0, 0.0])
        parts.append(box_part((sheet, width, height), middle, "helmet_yellow", turn))
        solids.append(OrientedBox(make_transform(turn, middle), np.array([sheet, width, height])))
        for size, up, paint in (((0.003, 0.20, 0.05), 0.16, "print_red"), ((0.003, 0.20, 0.20), -0.02, "print_dark")):
            at = middle + out * (sheet / 2 + 0.0005) + turn @ np.array([0.0, 0.0, up])
            parts.append(box_part(size, at, paint, turn))
    return assembled(name, "sign", 182, parts, solids, 1.1, turns=2)


def hanging_wrap(name: str) -> ObjectModel:
    """Build strips of stretch film that hang loose from a load: a wide torn one, and two roped ones beside it.

    Film gives way to whatever it touches, so it has no collision boxes.
    """
    obj_id, length, width = WRAPS[name]
    parts = []
    for fraction, broad, offset, phase in ((1.0, 1.0, 0.0, 0.0), (0.72, 0.25, 0.35, 1.7), (0.45, 0.16, -0.38, 3.1)):
        parts.append(mesh_part(_strip(fraction * length, broad * width, offset * width, length, phase), "stretch_film"))
    return assembled(name, "wrap", obj_id, parts, (), 0.0)


def _strip(drop: float, width: float, y: float, top: float, phase: float) -> TriangleMesh:
    """Return film that hangs ``drop`` (m) down from ``top`` at ``y`` and narrows towards its torn end."""
    fraction = np.linspace(0.0, 1.0, 15)
    sway = 0.03 * fraction * np.sin(2.5 * np.pi * fraction + phase)
    path = np.column_stack([sway, y + 0.4 * sway, top - drop * fraction])
    torn = np.interp(fraction, [0.0, 0.1, 0.45, 0.9, 1.0], [0.55, 1.0, 0.7, 0.45, 0.12]) * width / 2
    return tube(path, [(_FILM / 2 + 0.02 * half, half) for half in torn], sides=12)
