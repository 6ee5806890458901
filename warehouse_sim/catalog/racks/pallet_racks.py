"""Pallet racks: upright frames, beams, how far a real rack is from its drawing, and the rails of drive-in ones.

Axes of all: x along the aisle, of drive-in pieces across the lane, y into the rack, z up; origins at the centre of the
bounding box. A frame is two perforated uprights on base plates, laced by horizontals and diagonals. Beams have end
connectors; they are plain box beams, or step beams whose inner edge carries decks and bars. Clear bay widths for EPAL 1
pallets short side out, with 75 mm at every gap (EN 15620 class 400, X3-X6 up to 9 m): two pallets 1.825 m, three 2.7 m,
four 3.6 m (3.575 rounded up to the makers' catalogs). In drive-in racking pallets stand on rails along both sides of a
lane, one behind the other, long side out.

Tolerances are those of EN 15620:2008, tables 2 and 3, adjustable pallet racking of class 400, for an erected, unloaded
rack. A draw is normal with a third of the limit as its deviation and cut off at the limit, so that a rack is never out
of tolerance and seldom near it. The standard calls our x, y and z X, Z and Y.
"""

import numpy as np
from jaxtyping import Float

from warehouse_sim.catalog.parts import box_part, collision_boxes, fused, mesh_part, model_of, solid_box, solid_part
from warehouse_sim.catalog.racks.upright import UPRIGHT_DEPTH, UPRIGHT_WIDTH, upright_mesh
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_x, rotation_y, rotation_z
from warehouse_sim.geometry.solids import prism, unit_cylinder
from warehouse_sim.schema import ObjectModel, Part

FRAME_DEPTH = 1.1
"""Outer depth of a frame (m); a 1.2 m deep pallet overhangs it by 50 mm front and back."""

_LACING_PITCH = 0.6
_PLATE = (0.15, UPRIGHT_DEPTH + 0.04, 0.006)
_OBJ_IDS = {
    2000: 101,
    2500: 102,
    3500: 103,
    4500: 104,
    5500: 105,
    6500: 106,
    8000: 107,
    9500: 500,
    11000: 501,
    13000: 502,
}
"""Height (mm) -> obj_id."""

FRAME_HEIGHTS = {f"rack_frame_{mm}": mm / 1000 for mm in _OBJ_IDS}
"""Catalog name -> height (m), lowest first."""


def rack_frame(name: str) -> ObjectModel:
    """Build an upright frame."""
    height = FRAME_HEIGHTS[name]
    mesh, offset = upright_mesh(height), (FRAME_DEPTH - UPRIGHT_DEPTH) / 2
    front = mesh_part(mesh, "rack_blue", (0.0, -offset, 0.0))
    back = mesh_part(mesh, "rack_blue", (0.0, offset, 0.0), rotation_z(np.pi))
    uprights = [solid_box((UPRIGHT_WIDTH, UPRIGHT_DEPTH, height), (0.0, side * offset, 0.0)) for side in (-1.0, 1.0)]
    lacing = _lacing(height)
    plates = [box_part(_PLATE, (0.0, side * offset, (_PLATE[2] - height) / 2), "galvanised") for side in (-1.0, 1.0)]
    return model_of(
        name,
        "rack",
        _OBJ_IDS[round(1000 * height)],
        (_PLATE[0], FRAME_DEPTH + _PLATE[1] - UPRIGHT_DEPTH, height),
        (front, back, *fused([*plates, *_anchors(height, offset), *lacing])),
        (*uprights, *collision_boxes(plates + lacing)),
    )


def _anchors(height: float, offset: float) -> list[Part]:
    """Return the two bolts, M12 with 19 mm heads, that hold each base plate."""
    z = -height / 2 + _PLATE[2] + 0.004
    return [
        solid_part(unit_cylinder(8), (0.019, 0.019, 0.008), (x, side * offset, z), "galvanised")
        for side in (-1.0, 1.0)
        for x in (-0.0625, 0.0625)
    ]


def _lacing(height: float) -> list[Part]:
    """Return horizontals at both ends and diagonals in a zigzag between the uprights' inner faces."""
    span = FRAME_DEPTH - 2 * UPRIGHT_DEPTH
    low, high = -height / 2 + 0.15, height / 2 - 0.15
    bars = [box_part((0.03, span, 0.03), (0.0, 0.0, z), "galvanised") for z in (low, high)]
    count = max(1, round((high - low) / _LACING_PITCH))
    pitch = (high - low) / count
    # The bar's corners, not its axis, must stay between the uprights.
    length = np.hypot(span, pitch) - 0.03
    for index in range(count):
        rising = 1.0 if index % 2 == 0 else -1.0
        rotation = rotation_x(rising * np.arctan2(pitch, span))
        bars.append(box_part((0.025, length, 0.025), (0.0, 0.0, low + (index + 0.5) * pitch), "galvanised", rotation))
    return bars


BAY_WIDTH = 2.7
"""Clear width between two frames (m) of the bay for three pallets."""
RACK_BEAMS = {"rack_beam_1825": (112, 1.825), "rack_beam_2700": (111, BAY_WIDTH), "rack_beam_3600": (113, 3.6)}
STEP_BEAMS = {"step_beam_1825": (114, 1.825), "step_beam_2700": (115, BAY_WIDTH), "step_beam_3600": (116, 3.6)}
"""Catalog name -> obj_id and clear width between two frames (m)."""
BAY_WIDTHS = tuple(width for _, width in RACK_BEAMS.values())
"""Clear widths between two frames (m), rising."""
BEAM_HEIGHT, BEAM_DEPTH = 0.12, 0.05
"""Section of a beam along z and y (m)."""
CONNECTOR_HEIGHT = 0.19
"""Height of the plate at a beam's end, flush with the beam's top (m)."""
STEP_HEIGHT, STEP_DEPTH = 0.041, 0.022
"""How far a step beam's ledge lies under its top (1 5/8 in, the usual drop) and how wide it is (m)."""
CONNECTOR_SHEET = 0.004
"""Thickness of a connector (m); on a step beam it stands this far proud of the upright's front."""
CONNECTOR_LEG = 0.045
"""Width of the connector's leg on the front of an upright (m); the beams of both sides fit on 100 mm."""
STEP_BEAM_DEPTH = BEAM_DEPTH + CONNECTOR_SHEET
"""Depth of a step beam along y with its connectors' legs (m)."""

_LEG_SHEET = 0.003
_PAINT = "rack_orange"
_ALONG_X = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


def rack_beam(name: str) -> ObjectModel:
    """Build a box beam that fits between two uprights; z of the top is half the end plates' height."""
    obj_id, length = RACK_BEAMS[name]
    top = CONNECTOR_HEIGHT / 2
    lower = CONNECTOR_HEIGHT - BEAM_HEIGHT
    body = box_part((length, BEAM_DEPTH, BEAM_HEIGHT), (0.0, 0.0, top - BEAM_HEIGHT / 2), _PAINT)
    ends: list[Part] = []
    for side in (-1.0, 1.0):
        plate_x, leg_x = side * (length - CONNECTOR_SHEET) / 2, side * (length - CONNECTOR_LEG) / 2
        ends.append(box_part((CONNECTOR_SHEET, BEAM_DEPTH, lower), (plate_x, 0.0, -top + lower / 2), _PAINT))
        for face in (-1.0, 1.0):
            y = face * (BEAM_DEPTH - CONNECTOR_SHEET) / 2
            ends.append(box_part((CONNECTOR_LEG, CONNECTOR_SHEET, lower), (leg_x, y, -top + lower / 2), _PAINT))
    solid = [solid_box((length, BEAM_DEPTH, BEAM_HEIGHT), (0.0, 0.0, top - BEAM_HEIGHT / 2))]
    for side in (-1.0, 1.0):
        at = (side * (length - CONNECTOR_LEG) / 2, 0.0, -top + lower / 2)
        solid.append(solid_box((CONNECTOR_LEG, BEAM_DEPTH, lower), at))
    size = (length, BEAM_DEPTH, CONNECTOR_HEIGHT)
    return model_of(name, "rack", obj_id, size, fused([body, *ends]), solid, turns=2)


def step_beam(name: str) -> ObjectModel:
    """Build a step beam: front at -y, ledge at +y, connectors over the uprights' fronts.

    Its body lies between the uprights, ``CONNECTOR_SHEET`` behind the bounding box's front; the connectors' legs reach
    ``CONNECTOR_LEG`` over the uprights on both sides. The back beam of a level is the same one, turned by half.
    """
    obj_id, length = STEP_BEAMS[name]
    top, lower = CONNECTOR_HEIGHT / 2, CONNECTOR_HEIGHT - BEAM_HEIGHT
    middle, back = CONNECTOR_SHEET / 2, STEP_BEAM_DEPTH / 2
    front = back - BEAM_DEPTH
    bottom, step = top - BEAM_HEIGHT, top - STEP_HEIGHT
    # The section is sampled in (y, z) and extruded along its own z, which is then laid along x.
    section = ((front, bottom), (back, bottom), (back, step), (back - STEP_DEPTH, step), (back - STEP_DEPTH, top))
    body = mesh_part(prism((*section, (front, top)), length), _PAINT, rotation=_ALONG_X)
    plates: list[Part] = []
    pins: list[Part] = []
    for side in (-1.0, 1.0):
        x = side * (length - CONNECTOR_SHEET) / 2
        plates.append(box_part((CONNECTOR_SHEET, BEAM_DEPTH, lower), (x, middle, -top + lower / 2), _PAINT))
        leg = (side * (length + CONNECTOR_LEG) / 2, front - _LEG_SHEET / 2, 0.0)
        plates.append(box_part((CONNECTOR_LEG, _LEG_SHEET, CONNECTOR_HEIGHT), leg, _PAINT))
        # The lock that keeps a lifted beam on its upright (EN 15512); its head lies on the leg.
        pin = (side * (length / 2 + 0.028), front - CONNECTOR_SHEET / 2, 0.02)
        pins.append(box_part((0.012, CONNECTOR_SHEET, 0.03), pin, "galvanised"))
    lower_solid = solid_box((length, BEAM_DEPTH, BEAM_HEIGHT - STEP_HEIGHT), (0.0, middle, (bottom + step) / 2))
    upper_depth = BEAM_DEPTH - STEP_DEPTH
    upper_solid = solid_box((length, upper_depth, STEP_HEIGHT), (0.0, front + upper_depth / 2, top - STEP_HEIGHT / 2))
    solid = (lower_solid, upper_solid, *collision_boxes(plates))
    size = (length + 2 * CONNECTOR_LEG, STEP_BEAM_DEPTH, CONNECTOR_HEIGHT)
    return model_of(name, "rack", obj_id, size, fused([body, *plates, *pins]), solid)


FRONTAGE = 0.010
"""B0: a rack's front against its line on the floor (m)."""
PLUMB = 1.0 / 350.0
"""Cx, Cz: a frame's top against its foot, as a fraction of its height."""
BEAM_LEVEL, BEAM_FRACTION = 0.003, 1.0 / 500.0
"""Gy: a beam's level; the larger of a length (m) and a fraction of the beam's length counts."""
TWIST_DEG_PER_M = 1.0
"""Tw: a beam's twist at half its length (deg a metre of it)."""


def frame_pose(height: float, rng: np.random.Generator) -> Transform:
    """Return ``T_nominal_frame`` of a frame of ``height`` (m): shifted on the floor and out of plumb about its foot.

    Both poses have their origin at the frame's centre. The middle of the foot stays on the floor; base plates dip or
    rise by 1.6 mm at the limit, which on site is the work of shims.
    """
    lean_x, lean_y = (float(lean) for lean in np.arctan(_within(PLUMB, rng, 2)))
    shift = np.array([0.0, _within(FRONTAGE, rng), 0.0])
    to_foot = np.array([0.0, 0.0, height / 2])
    rotation = rotation_y(lean_x) @ rotation_x(-lean_y)
    return make_transform(translation=shift - to_foot) @ make_transform(rotation) @ make_transform(translation=to_foot)


def beam_pose(length: float, rng: np.random.Generator) -> Transform:
    """Return ``T_nominal_beam`` of a beam of ``length`` (m): its ends not quite level, its section a little twisted."""
    slope = float(_within(max(BEAM_LEVEL, BEAM_FRACTION * length), rng)) / length
    twist = float(np.deg2rad(_within(TWIST_DEG_PER_M, rng) * length / 2))
    return make_transform(rotation_y(-float(np.arctan(slope))) @ rotation_x(twist))


def _within(limit: float, rng: np.random.Generator, count: int | None = None) -> Float[np.ndarray, "..."]:
    """Draw from the normal distribution of deviation ``limit`` / 3, cut off at +-``limit``."""
    return np.clip(rng.normal(0.0, limit / 3.0, count), -limit, limit)


LANE_WIDTH = 1.35
"""Clear width between the frames (m): 1.2 m of pallet and 75 mm of play on each side (FEM 10.2.07)."""
PLACE_PITCH = 0.95
"""Distance from pallet to pallet along a lane (m), the length of a rail's piece."""
RAIL_HEIGHT = 0.14
"""From the underside of a rail to the surface that carries the pallet (m)."""
_EDGE = 0.04
"""Height of the guiding edge over that surface (m)."""
_LEDGE, _SHEET = 0.17, 0.004


def drive_in_rail(name: str = "drive_in_rail") -> ObjectModel:
    """Build a piece of rail for the left side of a lane: web at -x, ledge towards +x, a guiding edge above it."""
    height = RAIL_HEIGHT + _EDGE
    z_ledge = height / 2 - _EDGE - _SHEET / 2
    web = box_part((_SHEET, PLACE_PITCH, height), ((_SHEET - _LEDGE) / 2, 0.0, 0.0), "rack_orange")
    ledge = box_part((_LEDGE - _SHEET, PLACE_PITCH, _SHEET), (_SHEET / 2, 0.0, z_ledge), "rack_orange")
    lip = box_part(
        (_SHEET, PLACE_PITCH, 0.05), ((_LEDGE - _SHEET) / 2, 0.0, z_ledge - _SHEET / 2 - 0.025), "rack_orange"
    )
    # The arm that carries the rail at its middle, a welded plate.
    arm = box_part(
        (_LEDGE - 2 * _SHEET, 0.006, RAIL_HEIGHT - _SHEET), (0.0, 0.0, z_ledge - RAIL_HEIGHT / 2), "rack_orange"
    )
    parts = [web, ledge, lip, arm]
    return model_of(name, "rack", 506, (_LEDGE, PLACE_PITCH, height), fused(parts), collision_boxes(parts))


def drive_in_tie(name: str = "drive_in_tie") -> ObjectModel:
    """Build the beam that ties the frames of both sides of a lane together above the loads."""
    size = (LANE_WIDTH, 0.05, 0.1)
    parts = [box_part(size, (0.0, 0.0, 0.0), "rack_orange")]
    return model_of(name, "rack", 507, size, fused(parts), collision_boxes(parts), turns=2)
