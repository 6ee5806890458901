"""Lift trucks at work: forks raised for the drive, a seat that leaves the driver room under the guard.

Measures as in ``trucks``; the load is some 0.15 m over the floor, or just over the wheel arms.
"""

from warehouse_sim.catalog.parts import box_part, solid_box
from warehouse_sim.catalog.traffic.shapes import body, limb_box, round_wheel
from warehouse_sim.catalog.traffic.truck_pieces import (
    Mast,
    beacon,
    carriage,
    fork_pair,
    headlights,
    mast,
    overhead_guard,
    seat,
    steering,
)
from warehouse_sim.catalog.traffic.trucks import (
    FORKLIFT_HEIGHT,
    REACH_HEIGHT,
    REACH_WIDTH,
    fork_solids,
    reach_solids,
    sideways_seat,
)
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.schema import Part

COUNTERBALANCE_TOP, REACH_TOP = 0.26, 0.42
"""Top of the blades over the floor (m); a reach truck carries loads over its wheel arms."""


def counterbalance_parts() -> list[Part]:
    """Return the counterbalance truck with rounded counterweight, hood and fenders."""
    top = COUNTERBALANCE_TOP
    parts: list[Part] = [*fork_pair(top), *carriage(top, 1.0), *mast(Mast(FORKLIFT_HEIGHT, 0.74, -0.11, 2))]
    for side in (-1.0, 1.0):
        parts += round_wheel((-0.47, side * 0.445, 0.23), 0.46, 0.188)
        parts += round_wheel((-1.66, side * 0.42, 0.205), 0.41, 0.15)
    frame = ((-1.75, 0.14), (-0.30, 0.14), (-0.30, 0.42), (-0.75, 0.46), (-1.75, 0.46))
    cowl = ((-0.52, 0.40), (-0.30, 0.40), (-0.34, 0.92), (-0.44, 1.02), (-0.60, 1.02), (-0.54, 0.60))
    hood = ((-1.56, 0.44), (-0.96, 0.44), (-0.98, 0.70), (-1.06, 0.78), (-1.56, 0.78))
    weight = (
        *((-1.90, 0.20), (-1.50, 0.20), (-1.50, 0.44), (-1.52, 0.98), (-1.80, 0.98)),
        *((-1.93, 0.88), (-1.99, 0.62), (-1.98, 0.32)),
    )
    parts += [
        body(frame, 0.68, "truck_grey", radius=0.03),
        body(cowl, 0.86, "truck_grey", radius=0.07),
        body(hood, 1.00, "truck_orange", radius=0.06),
        body(weight, 0.70, "truck_grey", radius=0.12),
        box_part((0.50, 0.90, 0.03), (-0.78, 0.0, 0.475), "rubber"),
        box_part((0.10, 0.10, 0.10), (-1.96, 0.0, 0.45), "mast_black"),  # towing pin
    ]
    for side in (-1.0, 1.0):
        fender = (
            (-0.82, 0.40),
            (-0.76, 0.40),
            (-0.72, 0.50),
            (-0.26, 0.50),
            (-0.22, 0.44),
            (-0.18, 0.44),
            (-0.18, 0.55),
        )
        parts.append(body((*fender, (-0.76, 0.55)), 0.21, "truck_orange", side * 0.44, 0.05))
        flank = ((-1.92, 0.44), (-1.42, 0.44), (-1.46, 0.98), (-1.78, 0.98), (-1.92, 0.86))
        parts.append(body(flank, 0.20, "truck_grey", side * 0.42, 0.09))
        parts.append(box_part((0.46, 0.20, 0.05), (-1.06, side * 0.42, 0.24), "truck_grey"))
        parts.append(box_part((0.46, 0.03, 0.24), (-1.06, side * 0.33, 0.34), "truck_orange"))
        parts.append(box_part((0.02, 0.14, 0.07), (-1.925, side * 0.36, 0.80), "print_red"))  # tail lights
    posts = [((-0.42, 0.47, 0.55), (-0.66, 0.44, 2.0)), ((-1.72, 0.43, 0.98), (-1.50, 0.42, 2.0))]
    parts += overhead_guard(posts, (-1.53, -0.62, 0.42, 0.44), 2.04, "mast_black")
    parts += seat(-1.00, 0.76) + steering((-0.52, 0.0, 0.60), (-0.74, 0.0, 1.14))
    return parts + headlights(-0.44, 0.43, 1.36) + beacon(-1.45, -0.25, 2.03)


def counterbalance_solids() -> list[OrientedBox]:
    """Return the collision boxes of the counterbalance truck."""
    top = COUNTERBALANCE_TOP
    solids = [
        *fork_solids(top),
        solid_box((0.08, 1.0, 1.15), (-0.04, 0.0, top + 0.595)),
        solid_box((0.16, 0.74, FORKLIFT_HEIGHT - 0.06), (-0.16, 0.0, (FORKLIFT_HEIGHT + 0.06) / 2)),
        solid_box((1.83, 1.09, 0.55), (-1.095, 0.0, 0.275)),
        solid_box((0.32, 0.90, 0.65), (-0.46, 0.0, 0.72)),
        solid_box((1.09, 1.04, 0.55), (-1.465, 0.0, 0.71)),
        solid_box((0.60, 0.60, 0.66), (-1.29, 0.0, 1.10)),
        solid_box((1.0, 0.94, 0.08), (-1.07, 0.0, 2.0)),
        solid_box((0.40, 0.36, 0.66), (-0.72, 0.0, 0.92)),
        solid_box((0.12, 0.12, 0.11), (-1.45, -0.25, 2.08)),
        solid_box((0.14, 0.12, 0.12), (-1.95, 0.0, 0.45)),
    ]
    for side in (-1.0, 1.0):
        solids.append(limb_box((-0.42, side * 0.47, 0.55), (-0.66, side * 0.44, 2.0), 0.04))
        solids.append(limb_box((-1.72, side * 0.43, 0.98), (-1.50, side * 0.42, 2.0), 0.04))
        solids.append(solid_box((0.1, 0.12, 0.12), (-0.46, side * 0.43, 1.36)))
    return solids


def reach_parts() -> list[Part]:
    """Return the reach truck with its mast drawn in and its forks over the wheel arms."""
    top = REACH_TOP
    parts: list[Part] = [*fork_pair(top), *carriage(top, 0.8), *mast(Mast(REACH_HEIGHT, 0.74, -0.11, 3))]
    arm = ((-0.70, 0.06), (0.50, 0.06), (0.55, 0.12), (0.55, 0.17), (0.20, 0.22), (-0.70, 0.30))
    hull = ((-1.30, 0.10), (-0.34, 0.10), (-0.34, 0.98), (-0.62, 0.98), (-0.66, 0.42), (-1.30, 0.42))
    rear = ((-1.32, 0.40), (-1.06, 0.40), (-1.02, 1.02), (-1.10, 1.12), (-1.32, 1.06))
    for side in (-1.0, 1.0):
        parts.append(body(arm, 0.13, "truck_red", side * (REACH_WIDTH - 0.13) / 2, 0.05))
        parts += round_wheel((0.32, side * (REACH_WIDTH / 2 - 0.185), 0.1425), 0.285, 0.10)
    parts += [
        body(hull, REACH_WIDTH - 0.02, "truck_red", radius=0.06),
        body(rear, REACH_WIDTH - 0.02, "truck_grey", radius=0.10),
        box_part((0.26, REACH_WIDTH - 0.06, 0.40), (-0.49, 0.0, 0.70), "truck_grey"),
        box_part((0.40, 0.5, 0.42), (-0.86, 0.34, 0.62), "truck_grey"),
        box_part((0.20, 0.34, 0.16), (-0.55, -0.35, 1.06), "truck_grey"),
        box_part((0.02, 0.22, 0.15), (-0.66, -0.05, 1.10), "guard_black"),  # display
    ]
    parts += round_wheel((-1.05, 0.30, 0.17), 0.34, 0.12) + sideways_seat()
    posts = [((-0.38, 0.58, 0.90), (-0.42, 0.50, 2.15)), ((-1.24, 0.58, 1.0), (-1.20, 0.50, 2.15))]
    parts += overhead_guard(posts, (-1.20, -0.42, 0.50, 0.50), 2.19, "mast_black")
    return parts + steering((-0.62, -0.30, 0.90), (-0.72, -0.30, 1.16)) + beacon(-1.10, 0.30, 2.18)


def reach_truck_solids() -> list[OrientedBox]:
    """Return the collision boxes of the reach truck, its display included."""
    return [*reach_solids(REACH_TOP), solid_box((0.04, 0.24, 0.17), (-0.66, -0.05, 1.10))]
