"""Trucks that are walked: the hand pallet truck and the electric stacker, steered by a tiller.

Usual values of makers' type sheets (form VDI 2198): forks 1150 x 540 mm over all, 85 mm lowered, 190 mm raised,
steering wheels of 200 mm, load rollers of 82 mm; a 1.2 t stacker is 0.80 m wide and 1.95 m high with its mast lowered.
"""

import numpy as np

from warehouse_sim.catalog.parts import box_part, mesh_part, solid_box
from warehouse_sim.catalog.traffic.shapes import (
    bar,
    body,
    limb_box,
    rod,
    round_wheel,
    rounded,
    side_profile,
    tube,
)
from warehouse_sim.catalog.traffic.truck_pieces import FORK_LENGTH, Mast, mast
from warehouse_sim.catalog.traffic.trucks import JACK_FORK, JACK_LOWERED, JACK_SPREAD
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.schema import Part

JACK_RAISED, STACKER_TOP = 0.19, 0.24
"""Top of the forks over the floor, raised (m)."""


def _channel(top: float, y: float, paint: str) -> list[Part]:
    """Return one fork of pressed sheet: a plate with two flanges and a pointed, rounded toe."""
    length, sheet, deep = FORK_LENGTH, 0.005, 0.048
    parts = []
    plate = ((-0.06, top - sheet), (length - 0.07, top - sheet), (length, top - 0.022), (length - 0.01, top - 0.004))
    parts.append(side_profile((*plate, (length - 0.05, top), (-0.06, top)), JACK_FORK, paint, y))
    flange = (
        (-0.06, top - deep),
        (length - 0.13, top - deep),
        (length - 0.005, top - 0.024),
        (length - 0.07, top - 0.003),
    )
    for side in (-1.0, 1.0):
        at = y + side * (JACK_FORK - sheet) / 2
        parts.append(side_profile((*flange, (-0.06, top - 0.003)), sheet, paint, at))
    toe = (
        (length - 0.13, top - deep),
        (length - 0.03, top - 0.035),
        (length - 0.005, top - 0.02),
        (length - 0.13, top),
    )
    parts.append(side_profile(rounded(toe, 0.02), 0.7 * JACK_FORK, paint, y))
    return parts


def hand_pallet_truck_parts(top: float) -> list[Part]:
    """Return the hand pallet truck with the forks' top at ``top`` (m)."""
    paint, lift = "truck_yellow", top - JACK_LOWERED
    parts: list[Part] = []
    for side in (-1.0, 1.0):
        y = side * JACK_SPREAD / 2
        parts += _channel(top, y, paint)
        for x in (FORK_LENGTH - 0.15, FORK_LENGTH - 0.235):
            parts += round_wheel((x, y, 0.041), 0.082, 0.07, "chrome", "truck_grey")
        for off in (-0.045, 0.045):  # the fork that presses the rollers down, and its push rod
            swing = [(FORK_LENGTH - 0.16, y + off, 0.041), (FORK_LENGTH - 0.34, y + off, top - 0.03)]
            parts.append(mesh_part(bar([*swing], 0.009), "truck_grey"))
        parts.append(mesh_part(rod((-0.04, y, top - 0.032), (FORK_LENGTH - 0.34, y, top - 0.03), 0.01), "truck_grey"))
        # From each fork a flat arm climbs to the lifting head over the pump.
        foot, head = (-0.045, y, top - 0.02), (-0.085, side * 0.055, 0.40 + lift)
        middle = (-0.06, y * 0.86, top + 0.12)
        path = np.array([foot, middle, head])
        parts.append(mesh_part(tube(path, [(0.012, 0.045), (0.012, 0.04), (0.014, 0.035)], (0.0, 1.0, 0.0), 16), paint))
        parts += round_wheel((-0.20, side * 0.072, 0.10), 0.20, 0.05, "truck_grey")
    parts += [
        box_part((0.035, JACK_SPREAD + JACK_FORK - 0.02, 0.05), (-0.05, 0.0, top - 0.026), paint),
        box_part((0.10, 0.15, 0.045), (-0.12, 0.0, 0.40 + lift), paint),
        box_part((0.075, 0.06, 0.05), (-0.20, 0.0, 0.225), "truck_grey"),
        mesh_part(rod((-0.20, -0.10, 0.10), (-0.20, 0.10, 0.10), 0.014), "chrome"),
        mesh_part(rod((-0.20, 0.0, 0.12), (-0.20, 0.0, 0.34), 0.042, 32), "truck_grey"),  # pump
        mesh_part(rod((-0.165, 0.0, 0.25), (-0.165, 0.0, 0.41 + lift), 0.02, 24), "chrome"),  # its ram
        mesh_part(rod((-0.255, 0.0, 0.14), (-0.255, 0.0, 0.28), 0.028, 24), "truck_grey"),  # reservoir
    ]
    return parts + _tiller((-0.255, 0.0, 0.30), (-0.43, 0.0, 1.02), paint)


def _tiller(foot: tuple[float, float, float], neck: tuple[float, float, float], paint: str) -> list[Part]:
    """Return a drawbar from ``foot`` to ``neck`` (m) with a closed loop for both hands and a release lever."""
    turn = np.linspace(-0.5 * np.pi, 1.5 * np.pi, 49)
    lean = (neck[0] - foot[0]) / (neck[2] - foot[2])
    # A loop flat below and round above, in the drawbar's plane.
    up = 0.085 + 0.085 * np.sign(np.sin(turn)) * np.abs(np.sin(turn)) ** 0.7
    across = 0.175 * np.sign(np.cos(turn)) * np.abs(np.cos(turn)) ** 0.6
    loop = np.column_stack([neck[0] + lean * up, across, neck[2] + up])
    keep = np.r_[True, np.linalg.norm(np.diff(loop, axis=0), axis=1) > 1e-4]
    loop = loop[keep]
    lever = [(neck[0] + 0.01, 0.0, neck[2] + 0.02), (neck[0] + lean * 0.1 + 0.02, 0.03, neck[2] + 0.11)]
    return [
        mesh_part(rod(foot, neck, 0.019, 24), paint),
        box_part((0.06, 0.05, 0.09), foot, "truck_grey"),
        mesh_part(tube(loop, [(0.016, 0.016)] * len(loop), (1.0, 0.0, 0.2), 16), "rubber"),
        mesh_part(rod(lever[0], lever[1], 0.007), "print_red"),
    ]


def hand_pallet_truck_solids(top: float) -> list[OrientedBox]:
    """Return its collision boxes; they leave the space over the forks."""
    lift = top - JACK_LOWERED
    solids = [
        solid_box((0.09, JACK_SPREAD + JACK_FORK, 0.06), (-0.055, 0.0, top - 0.03)),
        solid_box((0.22, 0.34, 0.40), (-0.11, 0.0, top + 0.16)),
        solid_box((0.24, 0.22, 0.44 + lift), (-0.20, 0.0, 0.22 + lift / 2)),
        limb_box((-0.255, 0.0, 0.30), (-0.43, 0.0, 1.02), 0.04),
        solid_box((0.09, 0.39, 0.22), (-0.452, 0.0, 1.11)),
    ]
    for side in (-1.0, 1.0):
        y = side * JACK_SPREAD / 2
        solids.append(solid_box((0.09, 0.17, 0.18), (-0.06, side * 0.16, top + 0.05)))
        solids.append(solid_box((FORK_LENGTH + 0.06, JACK_FORK, 0.05), ((FORK_LENGTH - 0.06) / 2, y, top - 0.025)))
        solids.append(solid_box((0.32, JACK_FORK - 0.02, top), (FORK_LENGTH - 0.26, y, top / 2)))
    return solids


def stacker_parts() -> list[Part]:
    """Return the pedestrian stacker: pallet-truck forks before a mast, a drive unit with tiller behind."""
    top, paint = STACKER_TOP, "truck_yellow"
    parts: list[Part] = mast(Mast(1.95, 0.66, -0.10, 2))
    for side in (-1.0, 1.0):
        y = side * JACK_SPREAD / 2
        parts += _channel(top, y, "mast_black")
        arm = (
            (-0.30, 0.03),
            (FORK_LENGTH - 0.20, 0.03),
            (FORK_LENGTH - 0.16, 0.05),
            (FORK_LENGTH - 0.16, 0.08),
            (-0.30, 0.10),
        )
        parts.append(body(arm, 0.12, paint, y, 0.02))
        parts += round_wheel((FORK_LENGTH - 0.26, y, 0.0425), 0.085, 0.08, "chrome", "truck_grey")
        parts += round_wheel((-0.62, side * 0.31, 0.075), 0.15, 0.06)
        upright = ((-0.05, top - 0.05), (0.0, top - 0.05), (0.0, top + 0.03), (-0.03, top + 0.55), (-0.05, top + 0.55))
        parts.append(side_profile(upright, 0.08, "mast_black", y))
    for z in (0.05, 0.50):
        parts.append(box_part((0.03, 0.60, 0.08), (-0.055, 0.0, top + z), "mast_black"))
    hull = ((-0.80, 0.09), (-0.20, 0.09), (-0.20, 0.86), (-0.34, 0.90), (-0.62, 0.82), (-0.78, 0.62))
    parts += [
        body(hull, 0.80, paint, radius=0.10),
        body(((-0.815, 0.10), (-0.50, 0.10), (-0.50, 0.26), (-0.815, 0.26)), 0.78, "truck_grey", radius=0.04),
        box_part((0.012, 0.50, 0.62), (-0.205, 0.0, 1.25), "mast_black"),
        box_part((0.16, 0.22, 0.012), (-0.46, 0.15, 0.872), "guard_black"),
        *round_wheel((-0.60, 0.0, 0.115), 0.23, 0.07),
    ]
    parts += [
        mesh_part(bar([(-0.74, 0.0, 0.40), (-0.92, 0.0, 0.62), (-1.10, 0.0, 0.98)], 0.028), "truck_grey"),
        body(((-1.19, 0.97), (-1.06, 0.95), (-1.06, 1.03), (-1.17, 1.07)), 0.20, "truck_grey", radius=0.03),
        mesh_part(
            bar([(-1.13, -0.11, 1.0), (-1.13, -0.19, 1.02), (-1.11, -0.19, 1.06)], 0.016, (0.0, 0.0, 1.0)), "rubber"
        ),
        mesh_part(
            bar([(-1.13, 0.11, 1.0), (-1.13, 0.19, 1.02), (-1.11, 0.19, 1.06)], 0.016, (0.0, 0.0, 1.0)), "rubber"
        ),
        box_part((0.03, 0.07, 0.05), (-1.20, 0.0, 1.02), "print_red"),
    ]
    return parts


def stacker_solids() -> list[OrientedBox]:
    """Return the collision boxes of the stacker."""
    top = STACKER_TOP
    solids = [
        solid_box((0.16, 0.68, 1.90), (-0.14, 0.0, 1.00)),
        solid_box((0.62, 0.80, 0.88), (-0.51, 0.0, 0.46)),
        solid_box((0.06, 0.60, 0.66), (-0.03, 0.0, top + 0.27)),
        limb_box((-0.72, 0.0, 0.38), (-1.12, 0.0, 0.98), 0.06),
        solid_box((0.17, 0.43, 0.16), (-1.135, 0.0, 1.01)),
    ]
    for side in (-1.0, 1.0):
        y = side * JACK_SPREAD / 2
        solids.append(solid_box((FORK_LENGTH + 0.06, JACK_FORK, 0.05), ((FORK_LENGTH - 0.06) / 2, y, top - 0.025)))
        solids.append(solid_box((FORK_LENGTH + 0.14, 0.12, 0.10), ((FORK_LENGTH - 0.46) / 2, y, 0.05)))
    return solids
