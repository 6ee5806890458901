"""What carries the roof, and the luminaires under it. Origin at the centre of the bounding box, z up."""

import numpy as np

from warehouse_sim.catalog.building.shell import WALL_SIZE, profile, profile_points, profiled_solid
from warehouse_sim.catalog.parts import (
    Size,
    box_part,
    collision_boxes,
    fused,
    mesh_part,
    model_of,
    solid_box,
    solid_part,
)
from warehouse_sim.geometry.pose import rotation_y
from warehouse_sim.geometry.solids import lathe, prism
from warehouse_sim.schema import LuminousFace, ObjectModel

_LUMINAIRE_SIZE = (1.2, 0.32, 0.09)
"""Edges of a linear high-bay luminaire (m)."""
TRUSS_SIZE = (48.0, 0.2, 1.8)
"""Edges of a roof truss (m), x along it; depth about a 27th of the span."""
CEILING_SIZE = (48.0, 48.0, 0.24)
"""Edges of the roof seen from below (m): purlins along y under trapezoidal sheet."""

_HEB = (0.30, 0.30, 0.011, 0.019)
"""HEB 300: width, depth, web and flange (m), EN 10365."""
_STEEL_TUBE = 0.12


def column_steel(name: str = "column_steel", tall: float = WALL_SIZE[2]) -> ObjectModel:
    """Build a column of the section HEB 300 on a base plate, ``tall`` m high; its web lies along x."""
    depth, width, web, flange = _HEB[1], _HEB[0], _HEB[2], _HEB[3]
    plate = 0.03
    z, height = plate / 2, tall - plate
    parts = [box_part((0.5, 0.5, plate), (0.0, 0.0, (plate - tall) / 2), "steel_grey")]
    parts.append(box_part((depth - 2 * flange, web, height), (0.0, 0.0, z), "steel_grey"))
    for side in (-1.0, 1.0):
        parts.append(box_part((flange, width, height), (side * (depth - flange) / 2, 0.0, z), "steel_grey"))
    solid = [solid_box((depth, width, height), (0.0, 0.0, z)), *collision_boxes(parts[:1])]
    return model_of(name, "column", 142, (0.5, 0.5, tall), fused(parts), solid, turns=2)


def column_concrete(name: str = "column_concrete", tall: float = WALL_SIZE[2]) -> ObjectModel:
    """Build a precast column of 400 x 400 mm, ``tall`` m high: chamfered edges, warning stripes up to 1.5 m."""
    half, cut = 0.2, 0.015
    corners = [(half, cut - half), (half, half - cut), (half - cut, half), (cut - half, half)]
    outline = tuple(corners + [(-x, -y) for x, y in corners])
    # 2 mm of paint: the shaft is sampled thinner, so that the size is the painted one.
    shaft = solid_part(prism(outline, tall), (0.99, 0.99, 1.0), (0.0, 0.0, 0.0), "concrete")
    stripes = []
    for index in range(5):
        paint = "guard_yellow" if index % 2 == 0 else "guard_black"
        z = -tall / 2 + 0.3 * (index + 0.5)
        stripes.append(mesh_part(prism(outline, 0.3), paint, (0.0, 0.0, z)))
    size = (2 * half, 2 * half, tall)
    return model_of(name, "column", 143, size, (shaft, *fused(stripes)), turns=2)


def column_guard(name: str = "column_guard") -> ObjectModel:
    """Build the plastic collar around a column, yellow with black bands, for a column of up to 450 mm; 1.1 m high."""
    outer, wall, height, bands = 0.62, 0.08, 1.1, 5
    parts = []
    for index in range(bands):
        paint = "guard_yellow" if index % 2 == 0 else "guard_black"
        z = ((index + 0.5) / bands - 0.5) * height
        parts += [box_part(size, (x, y, z), paint) for size, (x, y) in _collar(outer, wall, height / bands)]
    solid = [solid_box(size, (x, y, 0.0)) for size, (x, y) in _collar(outer, wall, height)]
    return model_of(name, "guard", 144, (outer, outer, height), fused(parts), solid, turns=4, mass=12.0)


def ceiling(name: str = "ceiling", size: Size = CEILING_SIZE) -> ObjectModel:
    """Build the roof from below: trapezoidal sheet, its ribs along x, on purlins (IPE 140) along y every 2 m.

    A fascia along all four edges closes the gap between the walls and the sheet.
    """
    length, width, height = size
    x = profile_points(-width / 2, width / 2)
    low = height / 2 - 0.1 + 0.035 * profile(x)
    mesh = profiled_solid(x, low, np.full_like(x, height / 2), length)
    across = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])  # its x to y, its y up, its z to x
    sheet = mesh_part(mesh, "roof_sheet", rotation=across)
    purlins = []
    for at in np.linspace(-length / 2 + 1.0, length / 2 - 1.0, round(length / 2)):
        purlins.append(box_part((0.073, width, 0.007), (at, 0.0, -height / 2 + 0.0035), "steel_grey"))
        purlins.append(box_part((0.005, width, 0.133), (at, 0.0, -height / 2 + 0.007 + 0.0665), "steel_grey"))
    rise = height - 0.05
    for side in (-1.0, 1.0):
        z, end, edge = (rise - height) / 2, side * (length - WALL_SIZE[1]) / 2, side * (width - WALL_SIZE[1]) / 2
        purlins.append(box_part((length, WALL_SIZE[1], rise), (0.0, edge, z), "roof_sheet"))
        purlins.append(box_part((WALL_SIZE[1], width, rise), (end, 0.0, z), "roof_sheet"))
    return model_of(name, "ceiling", 145, size, (sheet, *fused(purlins)), turns=2)


def roof_truss(name: str = "roof_truss", size: Size = TRUSS_SIZE) -> ObjectModel:
    """Build a Warren truss of square tubes over the hall's width, with posts at every second node."""
    length, width, height = size
    chord, web, panels = width, min(_STEEL_TUBE, 0.6 * width), max(2 * round(length / 6.0), 4)
    parts = [box_part((length, chord, chord), (0.0, 0.0, s * (height - chord) / 2), "steel_grey") for s in (-1.0, 1.0)]
    pitch, rise = length / panels, height - 2 * chord
    for index in range(panels):
        angle = np.arctan2(rise, pitch) * (1.0 if index % 2 == 0 else -1.0)
        reach = np.hypot(rise, pitch) - 0.1
        x = (index + 0.5) * pitch - length / 2
        parts.append(box_part((reach, web, web), (x, 0.0, 0.0), "steel_grey", rotation_y(-angle)))
    for index in range(2, panels, 2):
        parts.append(box_part((web, web, rise), (index * pitch - length / 2, 0.0, 0.0), "steel_grey"))
    return model_of(name, "ceiling", 146, size, fused(parts), collision_boxes(parts), turns=2)


def highbay_luminaire(name: str = "highbay_luminaire") -> ObjectModel:
    """Build a linear LED luminaire that shines down."""
    length, width, height = _LUMINAIRE_SIZE
    glow = 0.01
    parts = (
        box_part((length, width, height - glow), (0.0, 0.0, glow / 2), "galvanised"),
        box_part((length - 0.04, width - 0.04, glow), (0.0, 0.0, (glow - height) / 2), "led_panel"),
    )
    up = np.array([0.0, 0.0, 1.0])
    face = LuminousFace("electric", "led_panel", "led_panel", up, height / 2, length * width)
    return model_of(name, "luminaire", 203, _LUMINAIRE_SIZE, parts, collision_boxes(parts), turns=2, luminous_face=face)


def luminaire_round(name: str = "luminaire_round") -> ObjectModel:
    """Build a round high-bay luminaire: a finned housing of 360 mm over a glowing disc, with its hanger."""
    body = lathe(((0.0, -0.06), (0.17, -0.06), (0.18, -0.04), (0.18, 0.0), (0.11, 0.02), (0.10, 0.09), (0.0, 0.09)))
    hanger = lathe(((0.0, 0.09), (0.015, 0.09), (0.015, 0.14), (0.0, 0.14)), 8)
    disc = lathe(((0.0, -0.07), (0.16, -0.07), (0.16, -0.06), (0.0, -0.06)))
    pieces = ((body, "mast_black"), (hanger, "galvanised"), (disc, "led_panel"))
    parts = [mesh_part(mesh, paint, (0.0, 0.0, -0.035)) for mesh, paint in pieces]
    solid = [solid_box((0.36, 0.36, 0.09), (0.0, 0.0, -0.06)), solid_box((0.22, 0.22, 0.12), (0.0, 0.0, 0.045))]
    up = np.array([0.0, 0.0, 1.0])
    face = LuminousFace("electric", "led_panel", "led_panel", up, 0.105, np.pi * 0.16**2)
    return model_of(name, "luminaire", 147, (0.36, 0.36, 0.21), parts, solid, turns=4, luminous_face=face)


def luminaire_trunking(name: str = "luminaire_trunking", length: float = 2.9) -> ObjectModel:
    """Build ``length`` m of light-line trunking, as it hangs in rows over aisles."""
    width, height, glow = 0.08, 0.09, 0.03
    parts = (
        box_part((length, width, height - glow), (0.0, 0.0, glow / 2), "sign_white"),
        box_part((length - 0.02, width - 0.015, glow), (0.0, 0.0, (glow - height) / 2), "led_panel"),
    )
    up = np.array([0.0, 0.0, 1.0])
    face = LuminousFace("electric", "led_panel", "led_panel", up, height / 2, length * width)
    return model_of(
        name, "luminaire", 148, (length, width, height), parts, collision_boxes(parts), turns=2, luminous_face=face
    )


def _collar(outer: float, wall: float, height: float) -> list[tuple[tuple[float, float, float], tuple[float, float]]]:
    """Return size and place (x, y) of four boxes that close around a square, each one a quarter turn on."""
    long, at = outer - wall, (outer - wall) / 2
    return [
        ((long, wall, height), (-wall / 2, -at)),
        ((wall, long, height), (at, -wall / 2)),
        ((long, wall, height), (wall / 2, at)),
        ((wall, long, height), (-at, wall / 2)),
    ]
