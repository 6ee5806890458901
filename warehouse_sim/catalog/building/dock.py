"""Loading docks: sectional doors closed and open, leveller, bumper, seal, and the trailer behind an open door.

Frame of all: origin at the centre of the bounding box, z up, x along the wall, y out of the hall (-y is inside). The
doors fit the opening of ``wall_module_dock`` and stand before the wall's inner face; sections are 600 mm high and
42 mm thick, as foamed steel panels are. Leveller after EN 1398: 2 x 2.5 m with a lip of 0.4 m.
"""

from functools import cache

import numpy as np

from warehouse_sim.catalog.building.shell import OPENING_HEIGHT, OPENING_WIDTH
from warehouse_sim.catalog.parts import box_part, collision_boxes, fused, model_of, solid_box, solid_part
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import rotation_y
from warehouse_sim.geometry.solids import unit_cylinder
from warehouse_sim.schema import ObjectModel, Part

TRAILER_SIZE = (2.55, 13.62, 2.7)
"""Width, length and inner height with roof of a semi-trailer's box (m); 2.55 m is the limit of 96/53/EC."""
LEVELLER_SIZE = (2.0, 2.5, 0.01)
"""Width, depth and thickness above the floor of the leveller's plate (m)."""
DOOR_SIZE = (OPENING_WIDTH + 0.3, 0.16, OPENING_HEIGHT + 0.5)
"""Outer size of a closed door with its tracks and shaft (m)."""
OPEN_DOOR_SIZE = (DOOR_SIZE[0], OPENING_HEIGHT + 0.35, DOOR_SIZE[2])
"""Outer size of an open door: the leaf lies under the roof, along the tracks (m)."""
SEAL_SIZE = (3.35, 0.2, 3.3)
"""Outer width, depth and height of the seal between wall and trailer (m)."""

_SECTIONS, _PANEL, _GROOVE = 5, 0.042, 0.008
_TRACK = 0.1
_LEAF_WIDTH = OPENING_WIDTH + 0.05  # it overlaps the wall, where a lip of rubber closes the gap
_CLOSED_LEAF_Y = 0.05  # of the leaf's middle, in a closed door's frame
_SEAL_WIDTH, _SEAL_HEIGHT = 2.4, 2.6
"""Clear width and height within a seal (m): its pads lie on the trailer's posts and on the edge of its roof."""
_PLEATS, _PLEAT_RELIEF = 8, 0.015
"""Pleats of a side pad, and how far every second one stands back (m)."""


def dock_door_closed(name: str = "dock_door_closed") -> ObjectModel:
    """Build a closed sectional door: five sections with a row of windows, a rubber seal, tracks, shaft and springs."""
    floor = -DOOR_SIZE[2] / 2
    leaf, section = [], OPENING_HEIGHT / _SECTIONS
    for index in range(_SECTIONS):
        z = floor + (index + 0.5) * section
        leaf.append(box_part((_LEAF_WIDTH, _PANEL, section - _GROOVE), (0.0, _CLOSED_LEAF_Y, z), "door_white"))
        if index == 2:
            leaf += _windows((0.0, _CLOSED_LEAF_Y, z))
    core = (_LEAF_WIDTH - 0.02, _PANEL - 0.012, OPENING_HEIGHT - 0.02)
    leaf.append(box_part(core, (0.0, _CLOSED_LEAF_Y, floor + OPENING_HEIGHT / 2), "steel_grey"))
    lips = _lips(floor)
    inner = _CLOSED_LEAF_Y - _PANEL / 2
    handle = [box_part((0.14, 0.03, 0.05), (-1.0, inner - 0.015, floor + 0.9), "guard_black")]
    frame = _frame(DOOR_SIZE[1] / 2)
    solid = solid_box((_LEAF_WIDTH, _PANEL, OPENING_HEIGHT), (0.0, _CLOSED_LEAF_Y, floor + OPENING_HEIGHT / 2))
    parts = fused([*leaf, *lips, *handle, *frame, *_shaft(DOOR_SIZE[1] / 2)])
    return model_of(
        name, "door", 150, DOOR_SIZE, parts, [solid, *collision_boxes(lips), *_frame_solids(frame, DOOR_SIZE[1] / 2)]
    )


def dock_door_open(name: str = "dock_door_open") -> ObjectModel:
    """Build the same door open: the leaf hangs level in its tracks, which reach into the hall above head height."""
    wall_face = OPEN_DOOR_SIZE[1] / 2
    top = -DOOR_SIZE[2] / 2 + OPENING_HEIGHT + 0.16
    section = OPENING_HEIGHT / _SECTIONS
    start = wall_face - 0.3
    leaf = []
    for index in range(_SECTIONS):
        y = start - (index + 0.5) * section
        leaf.append(box_part((_LEAF_WIDTH, section - _GROOVE, _PANEL), (0.0, y, top), "door_white"))
    rails: list[Part] = []
    length = OPEN_DOOR_SIZE[1] - 0.1
    for side in (-1.0, 1.0):
        x = side * (OPENING_WIDTH + 0.1) / 2
        rails.append(box_part((0.05, length, 0.06), (x, (-OPEN_DOOR_SIZE[1] + length) / 2, top), "galvanised"))
    frame = _frame(wall_face)
    parts = fused([*leaf, *rails, *frame, *_shaft(wall_face)])
    solid = solid_box((_LEAF_WIDTH, OPENING_HEIGHT, _PANEL), (0.0, start - OPENING_HEIGHT / 2, top))
    boxes = [solid, *collision_boxes(rails), *_frame_solids(frame, wall_face)]
    return model_of(name, "door", 151, OPEN_DOOR_SIZE, parts, boxes)


def dock_leveller(name: str = "dock_leveller") -> ObjectModel:
    """Build a leveller, level: its plate and lip in the floor's plane, hazard stripes at the sides."""
    width, depth, thick = LEVELLER_SIZE
    lip, stripe, gap = 0.4, 0.1, 0.012
    deck = depth - lip - gap
    inner = width - 2 * (stripe + gap)
    plate, relief = thick - 0.002, 0.002
    low = (plate - thick) / 2
    parts = [
        box_part((inner, deck, plate), (0.0, (deck - depth) / 2, low), "fork_steel"),
        box_part((inner - 0.1, lip, plate), (0.0, (depth - lip) / 2, low), "fork_steel"),
        box_part((width, depth, 0.002), (0.0, 0.0, (0.002 - thick) / 2), "floor_joint"),
    ]
    # Tear plate: raised bars in place of its lozenges, which are too fine to show.
    for y in np.arange(-depth / 2 + 0.05, depth / 2 - lip - 0.1, 0.1):
        parts.append(box_part((inner - 0.1, 0.012, relief), (0.0, y, (thick - relief) / 2), "fork_steel"))
    for side in (-1.0, 1.0):
        for index in range(10):
            paint = "guard_yellow" if index % 2 == 0 else "guard_black"
            at = (side * (width - stripe) / 2, -depth / 2 + (index + 0.5) * depth / 10, low)
            parts.append(box_part((stripe, depth / 10, plate), at, paint))
    return model_of(name, "dock", 152, LEVELLER_SIZE, fused(parts))


def dock_bumper(name: str = "dock_bumper") -> ObjectModel:
    """Build the rubber block of 250 x 100 x 500 mm that a trailer comes to rest against, with its four bolts."""
    block = box_part((0.25, 0.094, 0.5), (0.0, -0.003, 0.0), "rubber")
    bolts = [
        box_part((0.03, 0.006, 0.03), (x, 0.047, z), "galvanised", rotation_y(np.pi / 2))
        for x in (-0.07, 0.07)
        for z in (-0.18, 0.18)
    ]
    size = (0.25, 0.1, 0.5)
    return model_of(name, "dock", 153, size, (block, *fused(bolts)), mass=13.0)


def dock_seal(name: str = "dock_seal") -> ObjectModel:
    """Build the foam pads under pleated black fabric that a trailer is pressed against: one at each side and a head."""
    width, depth, height = SEAL_SIZE
    side, head = (width - _SEAL_WIDTH) / 2, height - _SEAL_HEIGHT
    pleat = _SEAL_HEIGHT / _PLEATS
    parts = [box_part((width, depth, head), (0.0, 0.0, (height - head) / 2), "rubber")]
    for sign in (-1.0, 1.0):
        for index in range(_PLEATS):
            inset = _PLEAT_RELIEF if index % 2 else 0.0
            z = (index + 0.5) * pleat - height / 2
            parts.append(box_part((side - inset, depth, pleat), (sign * (width - side + inset) / 2, 0.0, z), "rubber"))
    return model_of(name, "dock", 149, SEAL_SIZE, fused(parts), collision_boxes(parts))


@cache
def dock_sill(name: str = "dock_sill") -> ObjectModel:
    """Build the steel plate that lies outside the wall under a dock's seal, up to the trailer."""
    size = (SEAL_SIZE[0], SEAL_SIZE[1], 0.018)
    return model_of(name, "dock", 417, size, [box_part(size, (0.0, 0.0, 0.0), "fork_steel")], turns=2)


def trailer(name: str = "trailer") -> ObjectModel:
    """Build the inside of a semi-trailer that stands at the dock: open at -y, floor of wood, walls with slats."""
    width, length, height = TRAILER_SIZE
    wall, floor = 0.05, 0.03
    room = height - floor - wall
    shell = [
        box_part((width, length, floor), (0.0, 0.0, (floor - height) / 2), "pallet_wood_grey"),
        box_part((width, length, wall), (0.0, 0.0, (height - wall) / 2), "trailer_inside"),
        box_part((width - 2 * wall, wall, room), (0.0, (length - wall) / 2, (floor - wall) / 2), "trailer_inside"),
    ]
    slats: list[Part] = []
    for side in (-1.0, 1.0):
        x = side * (width - wall) / 2
        shell.append(box_part((wall, length, room), (x, 0.0, (floor - wall) / 2), "trailer_inside"))
        inside = side * (width / 2 - wall - 0.006)
        slats += [box_part((0.012, length, 0.10), (inside, 0.0, z), "pallet_wood") for z in (-0.9, -0.3, 0.3)]
        # The rear frame with the folded door and its seal.
        rear = (side * (width / 2 - 0.04), 0.02 - length / 2, (floor - wall) / 2)
        slats.append(box_part((0.08, 0.04, room), rear, "truck_grey"))
    return model_of(name, "trailer", 155, TRAILER_SIZE, fused([*shell, *slats]), collision_boxes(shell))


def _lips(floor: float) -> list[Part]:
    """Return the rubber under a closed leaf, and that between its other edges and the wall."""
    outer, wall_face = _CLOSED_LEAF_Y + _PANEL / 2, DOOR_SIZE[1] / 2
    gap, overlap = wall_face - outer, (_LEAF_WIDTH - OPENING_WIDTH) / 2
    lips = [box_part((_LEAF_WIDTH, 0.05, 0.04), (0.0, _CLOSED_LEAF_Y, floor + 0.02), "rubber")]
    # The head lip holds the edge of the uppermost section and reaches the wall above the opening.
    head = (_LEAF_WIDTH, _PANEL + gap + 0.004, 0.04 + _GROOVE)
    at = (0.0, wall_face - head[1] / 2, floor + OPENING_HEIGHT - _GROOVE + head[2] / 2)
    lips.append(box_part(head, at, "rubber"))
    for side in (-1.0, 1.0):
        at = (side * (_LEAF_WIDTH - overlap) / 2, outer + gap / 2, floor + OPENING_HEIGHT / 2)
        lips.append(box_part((overlap, gap, OPENING_HEIGHT), at, "rubber"))
    return lips


def _windows(section: tuple[float, float, float]) -> list[Part]:
    """Return three panes in their frames, a little proud of the section on both sides."""
    parts = []
    for x in (-0.85, 0.0, 0.85):
        at = (section[0] + x, section[1], section[2])
        parts.append(box_part((0.60, _PANEL + 0.010, 0.32), at, "guard_black"))
        parts.append(box_part((0.54, _PANEL + 0.014, 0.26), at, "window_pane"))
    return parts


def _frame(wall_face: float) -> list[Part]:
    """Return the upright tracks with their yellow impact guards, against the wall's face at y = ``wall_face``."""
    floor, parts = -DOOR_SIZE[2] / 2, []
    for side in (-1.0, 1.0):
        x = side * (DOOR_SIZE[0] - _TRACK) / 2
        parts.append(box_part((_TRACK, _TRACK, DOOR_SIZE[2]), (x, wall_face - _TRACK / 2, 0.0), "galvanised"))
        guard = (x, wall_face - _TRACK - 0.03, floor + 0.5)
        parts.append(box_part((_TRACK, 0.06, 1.0), guard, "guard_yellow"))
    return parts


def _shaft(wall_face: float) -> list[Part]:
    """Return the spring shaft with its two drums, above the opening."""
    z, y, along = DOOR_SIZE[2] / 2 - 0.15, wall_face - 0.08, rotation_y(np.pi / 2)
    pieces = [((0.03, 0.03, OPENING_WIDTH + 0.1), 0.0, "galvanised")]
    pieces += [((0.12, 0.12, 0.10), side * 1.25, "galvanised") for side in (-1.0, 1.0)]
    pieces += [((0.10, 0.10, 0.9), side * 0.55, "guard_black") for side in (-1.0, 1.0)]
    return [solid_part(unit_cylinder(16), size, (x, y, z), paint, along) for size, x, paint in pieces]


def _frame_solids(frame: list[Part], wall_face: float) -> list[OrientedBox]:
    shaft = solid_box((OPENING_WIDTH + 0.1, 0.12, 0.12), (0.0, wall_face - 0.08, DOOR_SIZE[2] / 2 - 0.15))
    return [*collision_boxes(frame), shaft]
