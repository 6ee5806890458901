"""Trucks that pull and carry: low-level order picker, tow tractor with its carts, mobile robot.

Usual values of makers' type sheets: an order picker is 0.80 m wide with forks of 1.15 m (one pallet); a stand-on tow
tractor 0.80 m wide, its carts 1.25 x 0.85 m; a robot that lifts pallets 1.20 x 0.80 m and 0.30 m high (ISO 3691-4).
"""

from warehouse_sim.catalog.parts import box_part, mesh_part, solid_box
from warehouse_sim.catalog.traffic.shapes import bar, body, rod, round_wheel, side_profile
from warehouse_sim.catalog.traffic.truck_pieces import FORK_LENGTH
from warehouse_sim.catalog.traffic.trucks import JACK_FORK, JACK_SPREAD
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.schema import Part

PICKER_TOP, PICKER_STAND = 0.22, 0.165
"""Top of the order picker's forks, and of the plate its driver stands on (m)."""
TUGGER_STAND, CART_TOP, CART_LENGTH = 0.155, 0.32, 1.25
ROBOT_TOP, ROBOT_LENGTH = 0.30, 1.20
"""Heights of decks and lengths (m)."""


def order_picker_parts() -> list[Part]:
    """Return the low-level order picker: forks, battery, a plate to stand on, drive unit with the steering."""
    top, paint = PICKER_TOP, "truck_red"
    parts: list[Part] = []
    for side in (-1.0, 1.0):
        y = side * JACK_SPREAD / 2
        blade = (
            (-0.10, top - 0.06),
            (FORK_LENGTH - 0.15, top - 0.06),
            (FORK_LENGTH, top - 0.03),
            (FORK_LENGTH - 0.03, top),
        )
        parts.append(side_profile((*blade, (-0.10, top)), JACK_FORK, "mast_black", y))
        for x in (FORK_LENGTH - 0.20, FORK_LENGTH - 0.30):
            parts += round_wheel((x, y, 0.0425), 0.085, 0.08, "chrome", "truck_grey")
        parts.append(
            mesh_part(rod((FORK_LENGTH - 0.25, y, 0.05), (FORK_LENGTH - 0.45, y, top - 0.05), 0.025), "truck_grey")
        )
        parts += round_wheel((-1.30, side * 0.33, 0.075), 0.15, 0.06)
        rail = [(-0.60, side * 0.36, 0.72), (-0.60, side * 0.36, 1.12), (-0.54, side * 0.30, 1.24), (-0.52, 0.0, 1.27)]
        parts.append(mesh_part(bar([*rail], 0.018, (1.0, 0.0, 0.0)), "mast_black"))
    battery = ((-0.60, 0.06), (-0.03, 0.06), (-0.03, 0.74), (-0.07, 0.80), (-0.60, 0.80))
    drive = ((-1.62, 0.06), (-1.08, 0.06), (-1.08, 0.98), (-1.20, 1.06), (-1.46, 0.92), (-1.62, 0.70))
    parts += [
        body(battery, 0.78, paint, radius=0.05),
        body(((-1.10, 0.05), (-0.58, 0.05), (-0.58, 0.15), (-1.10, 0.15)), 0.80, "truck_grey", radius=0.02),
        box_part((0.46, 0.70, 0.015), (-0.84, 0.0, 0.1575), "rubber"),
        box_part((0.05, 0.46, 0.36), (-0.63, 0.0, 1.0), "mast_black"),
        body(drive, 0.80, paint, radius=0.12),
        body(((-1.65, 0.08), (-1.35, 0.08), (-1.35, 0.30), (-1.65, 0.30)), 0.80, "truck_grey", radius=0.05),
        box_part((0.16, 0.30, 0.10), (-1.16, 0.0, 1.08), "truck_grey"),
        mesh_part(rod((-1.10, -0.20, 1.15), (-1.10, 0.20, 1.15), 0.018, 20), "rubber"),
    ]
    return parts


def order_picker_solids() -> list[OrientedBox]:
    """Return the collision boxes of the order picker; they leave room for the one who stands on it."""
    top = PICKER_TOP
    solids = [
        solid_box((0.57, 0.80, 0.80), (-0.315, 0.0, 0.41)),
        solid_box((0.14, 0.78, 0.52), (-0.585, 0.0, 1.03)),
        solid_box((0.56, 0.80, 0.17), (-0.84, 0.0, 0.085)),
        solid_box((0.58, 0.80, 1.06), (-1.36, 0.0, 0.53)),
        solid_box((0.20, 0.42, 0.18), (-1.16, 0.0, 1.09)),
    ]
    for side in (-1.0, 1.0):
        y = side * JACK_SPREAD / 2
        solids.append(solid_box((FORK_LENGTH + 0.10, JACK_FORK, 0.06), ((FORK_LENGTH - 0.10) / 2, y, top - 0.03)))
        solids.append(solid_box((0.40, 0.10, top), (FORK_LENGTH - 0.32, y, top / 2)))
    return solids


def tugger_parts() -> list[Part]:
    """Return the stand-on tow tractor, front at +x: drive unit, plate, back rest, coupling."""
    hull = ((0.0, 0.06), (0.62, 0.06), (0.66, 0.30), (0.60, 0.78), (0.40, 1.02), (0.10, 1.08), (0.0, 1.04))
    rear = ((-0.74, 0.06), (-0.50, 0.06), (-0.50, 0.98), (-0.58, 1.06), (-0.70, 0.98), (-0.74, 0.60))
    parts: list[Part] = [
        body(hull, 0.80, "truck_orange", radius=0.14),
        body(((0.10, 0.05), (0.69, 0.05), (0.69, 0.24), (0.10, 0.24)), 0.82, "truck_grey", radius=0.06),
        body(((-0.55, 0.05), (0.05, 0.05), (0.05, 0.14), (-0.55, 0.14)), 0.80, "truck_grey", radius=0.02),
        box_part((0.50, 0.68, 0.015), (-0.25, 0.0, 0.1475), "rubber"),
        body(rear, 0.78, "truck_orange", radius=0.08),
        box_part((0.05, 0.44, 0.30), (-0.485, 0.0, 0.92), "mast_black"),
        mesh_part(rod((0.05, 0.0, 0.95), (-0.02, 0.0, 1.16), 0.03, 20), "truck_grey"),
        mesh_part(rod((-0.02, -0.20, 1.17), (-0.02, 0.20, 1.17), 0.018, 20), "rubber"),
        box_part((0.10, 0.12, 0.06), (-0.77, 0.0, 0.27), "mast_black"),
        box_part((0.03, 0.30, 0.07), (0.625, 0.0, 0.62), "sign_white"),
        box_part((0.02, 0.10, 0.06), (-0.745, 0.28, 0.72), "print_red"),
        box_part((0.02, 0.10, 0.06), (-0.745, -0.28, 0.72), "print_red"),
    ]
    for side in (-1.0, 1.0):
        parts += round_wheel((-0.62, side * 0.34, 0.125), 0.25, 0.09)
    return parts + round_wheel((0.36, 0.0, 0.125), 0.25, 0.09)


def tugger_solids() -> list[OrientedBox]:
    """Return the collision boxes of the tow tractor."""
    return [
        solid_box((0.69, 0.82, 1.08), (0.345, 0.0, 0.54)),
        solid_box((0.14, 0.44, 0.26), (0.0, 0.0, 1.07)),
        solid_box((0.60, 0.80, 0.155), (-0.25, 0.0, 0.0775)),
        solid_box((0.30, 0.78, 1.07), (-0.61, 0.0, 0.535)),
        solid_box((0.12, 0.12, 0.08), (-0.77, 0.0, 0.27)),
    ]


def cart_parts() -> list[Part]:
    """Return a four-wheeled cart with its drawbar, which ends at +x; the deck's back edge is at x = 0."""
    top, length, width = CART_TOP, CART_LENGTH, 0.86
    parts: list[Part] = [
        box_part((length, width, 0.022), (length / 2, 0.0, top - 0.011), "truck_grey"),
        *(
            box_part((length, 0.05, 0.06), (length / 2, s * (width / 2 - 0.03), top - 0.052), "truck_orange")
            for s in (-1, 1)
        ),
        *(box_part((0.05, width - 0.02, 0.06), (x, 0.0, top - 0.052), "truck_orange") for x in (0.03, length - 0.03)),
        mesh_part(
            bar([(length - 0.10, 0.0, 0.24), (length + 0.20, 0.0, 0.26), (length + 0.50, 0.0, 0.27)], 0.02),
            "mast_black",
        ),
        box_part((0.08, 0.08, 0.03), (length + 0.52, 0.0, 0.27), "mast_black"),
    ]
    for x in (0.16, length - 0.16):
        for side in (-1.0, 1.0):
            parts += round_wheel((x, side * 0.33, 0.09), 0.18, 0.05)
            for off in (-0.034, 0.034):
                parts.append(box_part((0.05, 0.006, 0.16), (x, side * 0.33 + off, 0.17), "truck_grey"))
            parts.append(box_part((0.09, 0.09, 0.012), (x, side * 0.33, 0.245), "truck_grey"))
    return parts


def cart_solids() -> list[OrientedBox]:
    """Return the collision boxes of the cart."""
    top, length, width = CART_TOP, CART_LENGTH, 0.86
    return [
        solid_box((length, width, 0.09), (length / 2, 0.0, top - 0.045)),
        *(solid_box((0.20, 0.09, 0.25), (x, s * 0.33, 0.125)) for x in (0.16, length - 0.16) for s in (-1.0, 1.0)),
        solid_box((0.70, 0.09, 0.09), (length + 0.21, 0.0, 0.262)),
    ]


def robot_parts() -> list[Part]:
    """Return the mobile robot: a low rounded body with a lifting deck, scanners at two corners, a band of light."""
    top, length, width = ROBOT_TOP, ROBOT_LENGTH, 0.80
    low, high = ((0.0, 0.03), (length, 0.03), (length, 0.13), (0.0, 0.13)), 0.27
    cover = ((0.03, 0.165), (length - 0.03, 0.165), (length - 0.03, high), (0.03, high))
    parts: list[Part] = [
        body(low, width, "truck_grey", radius=0.03),
        box_part((length - 0.06, width - 0.06, 0.04), (length / 2, 0.0, 0.145), "guard_black"),
        body(cover, width - 0.02, "sign_white", radius=0.04),
        box_part((length - 0.16, width - 0.16, top - high), (length / 2, 0.0, (top + high) / 2), "mast_black"),
    ]
    for x, y in ((0.05, -0.35), (length - 0.05, 0.35)):
        parts.append(mesh_part(rod((x, y, 0.13), (x, y, 0.165), 0.045, 32), "truck_yellow"))
    for x in (0.027, length - 0.027):
        parts.append(box_part((0.008, 0.5, 0.02), (x, 0.0, 0.215), "lamp_orange"))
        parts.append(box_part((0.06, 0.06, 0.03), (x, 0.30, high - 0.01), "print_red"))
    for side in (-1.0, 1.0):
        parts += round_wheel((length / 2, side * 0.34, 0.09), 0.18, 0.06)
        for x in (0.12, length - 0.12):
            parts += round_wheel((x, side * 0.30, 0.04), 0.08, 0.035)
    return parts


def robot_solids() -> list[OrientedBox]:
    """Return the collision boxes of the robot."""
    top, length, width = ROBOT_TOP, ROBOT_LENGTH, 0.80
    return [
        solid_box((length, width, 0.27), (length / 2, 0.0, 0.135)),
        solid_box((length - 0.16, width - 0.16, top), (length / 2, 0.0, top / 2)),
        *(solid_box((0.08, 0.07, 0.03), (x, 0.30, 0.275)) for x in (0.03, length - 0.03)),
    ]
