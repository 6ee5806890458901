"""Safety and order on walls and beside ways: signs, extinguishers, hose cabinets, bins, rails, gates.

Frame of all: origin at the centre of the bounding box, z up; what hangs on a wall faces -y, its back is at +y. Colours
are those of ISO 3864: red for fire equipment, green for escape, blue for what must be done.
"""

from collections.abc import Sequence

import numpy as np

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
from warehouse_sim.geometry.pose import rotation_x, rotation_y
from warehouse_sim.geometry.solids import lathe, prism, unit_cylinder
from warehouse_sim.schema import LuminousFace, ObjectModel, Part

GATE_SIZE = (4.2, 0.14, 4.4)
"""Outer width, depth and height of the drive-in door with its frame (m)."""
_LEAF_SIZE = (3.8, 4.2)  # width and height of its leaf, or of the sky that it shows when open (m)
_LEAF_MATERIAL = "gate_leaf"


def drive_in_door(name: str = "drive_in_door") -> ObjectModel:
    """Build the door: a leaf on the floor between two jambs and the box of its roller, before the wall's inner face."""
    width, depth, height = GATE_SIZE
    leaf_width, leaf_height = _LEAF_SIZE
    jamb, lintel, floor = (width - leaf_width) / 2, height - leaf_height, -height / 2
    frame = [
        box_part((jamb, depth, height), (side * (width - jamb) / 2, 0.0, 0.0), "galvanised") for side in (-1.0, 1.0)
    ]
    frame.append(box_part((leaf_width, depth, lintel), (0.0, 0.0, (height - lintel) / 2), "galvanised"))
    thick = 0.04
    leaf = box_part((leaf_width, thick, leaf_height), (0.0, depth / 2 - thick, floor + leaf_height / 2), _LEAF_MATERIAL)
    sky = LuminousFace(
        "daylight", _LEAF_MATERIAL, _LEAF_MATERIAL, np.array([0.0, 1.0, 0.0]), depth / 2, leaf_width * leaf_height
    )
    solid = collision_boxes([*frame, leaf])
    return model_of(name, "door", 154, GATE_SIZE, (*fused(frame), leaf), solid, luminous_face=sky)


_INK = 0.001
Mark = tuple[tuple[float, float], tuple[float, float]]
"""Width and height of a mark, and its middle on the face (m)."""
_SEGMENTS = ("abcdef", "bc", "abged", "abgcd", "fgbc", "afgcd", "afgedc", "abc", "abcdefg", "abcfgd")
"""Bars of a seven-segment display that each digit is made of."""
_BARS = {
    "a": (0.0, 1.0, True), "b": (0.5, 0.5, False), "c": (0.5, -0.5, False), "d": (0.0, -1.0, True),
    "e": (-0.5, -0.5, False), "f": (-0.5, 0.5, False), "g": (0.0, 0.0, True),
}  # fmt: skip
"""Bar -> its middle (in half heights of the digit) and whether it lies."""
AISLE_SIGNS = {f"aisle_sign_{number:02d}": number for number in range(1, 13)}
"""Catalog name -> number of the aisle."""
FLOOR_LABELS = {f"floor_label_{number:02d}": number for number in range(1, 9)}
"""Catalog name -> number that its barcode is sampled from."""


def extinguisher(name: str = "extinguisher") -> ObjectModel:
    """Build a 6 kg powder extinguisher that hangs on its bracket: a red cylinder, black hose and valve."""
    body = lathe(((0.0, -0.22), (0.075, -0.22), (0.08, -0.2), (0.08, 0.14), (0.05, 0.19), (0.02, 0.2), (0.0, 0.2)), 16)
    size = (0.2, 0.172, 0.52)
    low = -0.04
    parts = [mesh_part(body, "safety_red", (-0.02, -0.004, low))]
    parts.append(box_part((0.05, 0.04, 0.06), (-0.02, 0.0, low + 0.23), "mast_black"))
    parts.append(box_part((0.14, 0.03, 0.02), (0.0, 0.0, size[2] / 2 - 0.01), "mast_black"))
    parts.append(box_part((0.025, 0.025, 0.4), (0.0875, 0.0, 0.02), "rubber"))
    parts.append(box_part((0.1, 0.002, 0.16), (-0.02, -0.085, low), "label_paper"))
    parts.append(box_part((0.06, 0.01, 0.3), (-0.02, 0.081, 0.0), "galvanised"))
    return model_of(name, "fire_equipment", 420, size, fused(parts), mass=9.0)


def fire_hose_cabinet(name: str = "fire_hose_cabinet") -> ObjectModel:
    """Build a red cabinet for a fire hose, 700 x 250 x 700 mm, with its white sign."""
    size = (0.7, 0.25, 0.7)
    face = -size[1] / 2
    parts = [box_part((0.7, 0.244, 0.7), (0.0, 0.003, 0.0), "safety_red")]
    parts.append(box_part((0.22, 0.003, 0.22), (0.14, face + 0.0045, 0.18), "sign_white"))
    parts.append(box_part((0.16, 0.002, 0.16), (0.14, face + 0.002, 0.18), "safety_red"))
    parts.append(box_part((0.03, 0.006, 0.12), (-0.29, face + 0.003, 0.0), "chrome"))
    return model_of(name, "fire_equipment", 421, size, fused(parts))


def fire_sign(name: str = "fire_sign") -> ObjectModel:
    """Build the red sign of 300 x 300 mm over an extinguisher: a white cylinder beside a flame."""
    marks = [((0.07, 0.16), (-0.05, -0.03)), ((0.03, 0.04), (-0.05, 0.07)), ((0.05, 0.12), (0.07, -0.05))]
    return _sign(name, 422, (0.3, 0.3), "safety_red", marks)


def exit_sign(name: str = "exit_sign") -> ObjectModel:
    """Build the green sign of 600 x 300 mm over a way out: a white door, a running figure and an arrow."""
    width, height = 0.6, 0.3
    marks = [((0.09, 0.2), (-0.2, 0.0)), ((0.05, 0.12), (-0.02, 0.0)), ((0.14, 0.03), (0.16, 0.0))]
    runner = [((0.045, 0.045), (0.0, 0.09)), ((0.11, 0.025), (0.0, 0.03)), ((0.025, 0.09), (-0.04, -0.085))]
    parts = list(_sign(name, 423, (width, height), "sign_green", [*marks, *runner]).parts)
    head = prism(((0.0, -0.06), (0.07, 0.0), (0.0, 0.06)), _INK)
    parts.append(mesh_part(head, "sign_white", (0.21, _INK / 2 - 0.005, 0.0), rotation_x(np.pi / 2)))
    return model_of(name, "sign", 423, (width, 0.01, height), fused(parts), (), mass=0.8)


def mandatory_sign(name: str = "mandatory_sign") -> ObjectModel:
    """Build the round blue sign of 400 mm that requires helmets or shoes."""
    size = (0.4, 0.01, 0.4)
    disk = solid_part(unit_cylinder(32), (0.4, 0.4, 0.009), (0.0, 0.0005, 0.0), "safety_blue", rotation_x(np.pi / 2))
    marks = [((0.12, 0.06), (0.0, 0.06)), ((0.16, 0.02), (0.0, 0.02)), ((0.09, 0.08), (0.0, -0.04))]
    return model_of(name, "sign", 424, size, (disk, *_marks(marks, -0.005)), (), mass=0.6)


def aisle_sign(name: str = "aisle_sign_01") -> ObjectModel:
    """Build the board of 600 x 600 mm that hangs over an aisle's end: its number, white on blue, on both faces."""
    number, edge, thick = AISLE_SIGNS[name], 0.6, 0.02
    parts = [box_part((edge, thick - 2 * _INK, edge), (0.0, 0.0, 0.0), "safety_blue")]
    for side in (-1.0, 1.0):
        for place, digit in zip((-0.13, 0.13), divmod(number, 10), strict=True):
            parts += _digit(digit, -side * place, side * (thick - _INK) / 2, 0.2, "sign_white", -side)
    return model_of(name, "sign", 440 + number, (edge, thick, edge), fused(parts), (), mass=2.0)


def floor_label(name: str = "floor_label_01") -> ObjectModel:
    """Build the label of a place on the floor, 400 x 200 mm and flat: a barcode over a number, read from -y."""
    number, length, width, film = FLOOR_LABELS[name], 0.4, 0.2, 0.001
    rng = np.random.default_rng([425, number])
    ground = 0.0006
    parts = [box_part((length, width, ground), (0.0, 0.0, (ground - film) / 2), "sign_white")]
    up, x = film / 2 - (film - ground) / 2, -0.17
    while x < 0.16:
        bar, gap = (0.004 * rng.integers(1, 4) for _ in range(2))
        parts.append(box_part((bar, 0.11, film - ground), (x + bar / 2, 0.03, up), "print_dark"))
        x += bar + gap
    for place in range(8):
        digit = int(rng.integers(10))
        for part in _digit(digit, 0.0, 0.0, 0.016, "print_dark"):
            sx, _, sz = part.scale
            at = part.T_object_part[:3, 3]
            centre = (at[0] + 0.03 * (place - 3.5), at[2] - 0.062, up)
            parts.append(box_part((sx, sz, film - ground), centre, "print_dark"))
    return model_of(name, "sign", 460 + number, (length, width, film), fused(parts), ())


def rubbish_bin(name: str = "rubbish_bin") -> ObjectModel:
    """Build a wheeled bin of 240 l after EN 840-1: a tapered body, a lid with its rim, two wheels behind."""
    size = (0.58, 0.73, 1.065)
    foot = -size[2] / 2
    parts = [box_part((0.44, 0.48, 0.86), (0.0, -0.04, foot + 0.52), "bin_green")]
    parts.append(box_part((0.50, 0.55, 0.45), (0.0, -0.03, foot + 0.72), "bin_green"))
    parts.append(box_part((0.58, 0.66, 0.05), (0.0, -0.035, foot + 0.97), "bin_green"))
    parts.append(box_part((0.54, 0.60, 0.07), (0.0, -0.03, foot + 1.03), "bin_green"))
    parts.append(box_part((0.46, 0.03, 0.03), (0.0, size[1] / 2 - 0.015, foot + 0.97), "bin_green"))
    for side in (-1.0, 1.0):
        parts.append(
            solid_part(
                unit_cylinder(16), (0.2, 0.2, 0.04), (side * 0.25, 0.24, foot + 0.1), "rubber", rotation_y(np.pi / 2)
            )
        )
        parts.append(box_part((0.03, 0.08, 0.03), (side * 0.2, size[1] / 2 - 0.06, foot + 0.97), "bin_green"))
    solid = [solid_box(size)]
    return model_of(name, "bin", 427, size, fused(parts), solid, mass=14.0)


def guard_rail(name: str = "guard_rail") -> ObjectModel:
    """Build 2 m of the yellow rail that parts a footway from trucks: two posts, two rails and a kick plate."""
    length, depth, height = 2.0, 0.16, 1.1
    foot = -height / 2
    plates = [box_part((0.16, depth, 0.012), (side * 0.92, 0.0, foot + 0.006), "guard_black") for side in (-1.0, 1.0)]
    posts = [box_part((0.08, 0.08, height - 0.012), (side * 0.92, 0.0, 0.006), "guard_yellow") for side in (-1.0, 1.0)]
    rails = [box_part((length, 0.06, 0.07), (0.0, -0.05, z), "guard_yellow") for z in (height / 2 - 0.06, 0.02)]
    kick = box_part((length, 0.02, 0.15), (0.0, -0.05, foot + 0.1), "guard_yellow")
    parts = [*plates, *posts, *rails, kick]
    return model_of(name, "guard", 428, (length, depth, height), fused(parts), collision_boxes(parts), mass=34.0)


def _sign(name: str, obj_id: int, size_wh: tuple[float, float], ground: str, marks: Sequence[Mark]) -> ObjectModel:
    """Return a flat sign of 10 mm with white marks, each its size and middle on the face (m)."""
    size: Size = (size_wh[0], 0.01, size_wh[1])
    board = box_part((size[0], 0.009, size[2]), (0.0, 0.0005, 0.0), ground)
    return model_of(name, "sign", obj_id, size, (board, *_marks(marks, -0.005)), (), mass=0.5)


def _marks(marks: Sequence[Mark], face: float) -> tuple[Part, ...]:
    """Return white marks just within a face at y = ``face`` (m)."""
    return fused([box_part((w, _INK, h), (x, face + _INK / 2, z), "sign_white") for (w, h), (x, z) in marks])


def _digit(digit: int, x: float, y: float, half: float, material: str, right: float = 1.0) -> list[Part]:
    """Return the bars of a digit ``2 * half`` m high at ``x``, ``y`` (m), whose reader's right is +x, or -x with -1."""
    thick, wide = 0.28 * half, 0.9 * half
    parts = []
    for bar in _SEGMENTS[digit]:
        across, up, lies = _BARS[bar]
        size = (wide, _INK, thick) if lies else (thick, _INK, half)
        lift = up * (half - thick / 2)
        parts.append(box_part(size, (x + right * across * (wide - thick), y, lift), material))
    return parts
