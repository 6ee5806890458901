"""Industrial trucks, parked and at work: counterbalance truck, reach truck; the plain hand pallet truck.

Measures are usual values of makers' type sheets (form VDI 2198), no single model's: for a 1.6 t electric counterbalance
truck 1.99 m to the forks' faces (l2), 1.09 m wide (b1), mast lowered 2.15 m (h1), guard 2.04 m (h6); for a 1.4 t reach
truck 1.27 m wide, mast lowered 2.80 m, guard 2.19 m; for a hand pallet truck 1150 x 540 mm over the forks, 85 mm
lowered, handle 1.23 m high. Forks point to +x.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from warehouse_sim.catalog.parts import box_part, mesh_part, solid_box, solid_part
from warehouse_sim.catalog.traffic.shapes import (
    Outline,
    assembled,
    body,
    limb_box,
    rod,
    round_wheel,
    side_profile,
    tube,
    wheel,
)
from warehouse_sim.catalog.traffic.truck_pieces import (
    FORK_LENGTH,
    FORK_SPREAD,
    FORK_THICKNESS,
    FORK_WIDTH,
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
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.solids import superellipsoid
from warehouse_sim.schema import ObjectModel, Part

FORKLIFT_WIDTH, FORKLIFT_LENGTH, FORKLIFT_HEIGHT = 1.09, 1.99 + FORK_LENGTH, 2.15
"""Over all, of the counterbalance truck with forks (m)."""
REACH_WIDTH, REACH_HEIGHT = 1.27, 2.80
"""Over all, of the reach truck with its mast drawn in (m)."""
JACK_LOWERED, JACK_FORK, JACK_SPREAD = 0.085, 0.16, 0.38
"""Height of the lowered forks, width of one, distance of their middles (m) of the hand pallet truck."""

COUNTERBALANCE_TOP, REACH_TOP = 0.26, 0.42
"""Top of the blades over the floor at work (m); a reach truck carries loads over its wheel arms."""
_FORK_TOP = 0.10


def forklift(name: str = "forklift") -> ObjectModel:
    """Build the counterbalance truck, parked with its forks 60 mm above the floor."""
    return assembled(name, "forklift", 177, _counterbalance(_PARKED, _FORK_TOP), _forklift_solids(), 3100.0)


def counterbalance_parts() -> list[Part]:
    """Return the counterbalance truck at work: finely divided, lower in the seat, with towing pin and tail lights."""
    return _counterbalance(_AT_WORK, COUNTERBALANCE_TOP)


@dataclass(frozen=True)
class _Counterbalance:
    """In what the plain counterbalance truck and the fine one differ; outlines are side views (x, z), lengths in m."""

    cowl: Outline
    hood: Outline
    weight: Outline
    weight_width: float
    fender: Outline
    flank: Outline
    flank_place: tuple[float, float]
    """Width of a flank and y of its middle."""
    seat: tuple[float, float]
    steering: tuple[float, float]
    """x and z of the steering wheel."""
    fine: bool


_PARKED = _Counterbalance(
    cowl=((-0.52, 0.40), (-0.30, 0.40), (-0.34, 0.92), (-0.44, 1.04), (-0.60, 1.04), (-0.56, 0.60)),
    hood=((-1.46, 0.44), (-0.90, 0.44), (-0.94, 0.94), (-1.00, 0.98), (-1.46, 0.98)),
    weight=(
        *((-1.90, 0.20), (-1.50, 0.20), (-1.50, 0.40), (-1.56, 0.98), (-1.80, 0.98)),
        *((-1.93, 0.88), (-1.99, 0.62), (-1.98, 0.32)),
    ),
    weight_width=0.66,
    fender=((-0.80, 0.44), (-0.20, 0.44), (-0.20, 0.52), (-0.72, 0.54), (-0.80, 0.50)),
    flank=((-1.90, 0.44), (-1.42, 0.44), (-1.42, 0.98), (-1.80, 0.98), (-1.90, 0.88)),
    flank_place=(0.17, 0.41),
    seat=(-0.98, 0.97),
    steering=(-0.72, 1.20),
    fine=False,
)
_AT_WORK = _Counterbalance(
    cowl=((-0.52, 0.40), (-0.30, 0.40), (-0.34, 0.92), (-0.44, 1.02), (-0.60, 1.02), (-0.54, 0.60)),
    hood=((-1.56, 0.44), (-0.96, 0.44), (-0.98, 0.70), (-1.06, 0.78), (-1.56, 0.78)),
    weight=(
        *((-1.90, 0.20), (-1.50, 0.20), (-1.50, 0.44), (-1.52, 0.98), (-1.80, 0.98)),
        *((-1.93, 0.88), (-1.99, 0.62), (-1.98, 0.32)),
    ),
    weight_width=0.70,
    fender=(
        *((-0.82, 0.40), (-0.76, 0.40), (-0.72, 0.50), (-0.26, 0.50)),
        *((-0.22, 0.44), (-0.18, 0.44), (-0.18, 0.55), (-0.76, 0.55)),
    ),
    flank=((-1.92, 0.44), (-1.42, 0.44), (-1.46, 0.98), (-1.78, 0.98), (-1.92, 0.86)),
    flank_place=(0.20, 0.42),
    seat=(-1.00, 0.76),
    steering=(-0.74, 1.14),
    fine=True,
)


def _counterbalance(shape: _Counterbalance, top: float) -> list[Part]:
    """Return the counterbalance truck whose blades have their top at ``top`` (m)."""
    solid, rolling = _style(shape.fine)
    parts: list[Part] = [*fork_pair(top), *carriage(top, 1.0), *mast(Mast(FORKLIFT_HEIGHT, 0.74, -0.11, 2))]
    for side in (-1.0, 1.0):
        parts += rolling((-0.47, side * 0.445, 0.23), 0.46, 0.188)
        parts += rolling((-1.66, side * 0.42, 0.205), 0.41, 0.15)
    frame = ((-1.75, 0.14), (-0.30, 0.14), (-0.30, 0.42), (-0.75, 0.46), (-1.75, 0.46))
    parts += [
        solid(frame, 0.68, "truck_grey", 0.0, 0.03),
        solid(shape.cowl, 0.86, "truck_grey", 0.0, 0.07),
        solid(shape.hood, 1.00, "truck_orange", 0.0, 0.06),
        solid(shape.weight, shape.weight_width, "truck_grey", 0.0, 0.12),
        box_part((0.50, 0.90, 0.03), (-0.78, 0.0, 0.475), "rubber"),
    ]
    if shape.fine:
        parts.append(box_part((0.10, 0.10, 0.10), (-1.96, 0.0, 0.45), "mast_black"))  # towing pin
    width, y = shape.flank_place
    for side in (-1.0, 1.0):
        # Fender, the weight's flank above the rear wheel, and the step between the axles.
        parts.append(solid(shape.fender, 0.21, "truck_orange", side * 0.44, 0.05))
        parts.append(solid(shape.flank, width, "truck_grey", side * y, 0.09))
        parts.append(box_part((0.46, 0.20, 0.05), (-1.06, side * 0.42, 0.24), "truck_grey"))
        parts.append(box_part((0.46, 0.03, 0.24), (-1.06, side * 0.33, 0.34), "truck_orange"))
        if shape.fine:
            parts.append(box_part((0.02, 0.14, 0.07), (-1.925, side * 0.36, 0.80), "print_red"))  # tail lights
    posts = [((-0.42, 0.47, 0.55), (-0.66, 0.44, 2.0)), ((-1.72, 0.43, 0.98), (-1.50, 0.42, 2.0))]
    parts += overhead_guard(posts, (-1.53, -0.62, 0.42, 0.44), 2.04, "mast_black")
    parts += seat(*shape.seat) + steering((-0.52, 0.0, 0.60), (shape.steering[0], 0.0, shape.steering[1]))
    return parts + headlights(-0.44, 0.43, 1.36) + beacon(-1.45, -0.25, 2.03)


def _forklift_solids() -> list[OrientedBox]:
    return [
        *_mast_solids(_FORK_TOP),
        solid_box((1.79, 1.09, 0.54), (-1.095, 0.0, 0.27)),
        solid_box((0.32, 0.90, 0.65), (-0.46, 0.0, 0.80)),
        solid_box((1.09, 1.0, 0.5), (-1.445, 0.0, 0.73)),
        solid_box((0.60, 0.60, 0.66), (-1.27, 0.0, 1.30)),
        solid_box((1.0, 0.94, 0.08), (-1.07, 0.0, 2.0)),
        solid_box((0.38, 0.36, 0.66), (-0.70, 0.0, 0.96)),
        solid_box((0.12, 0.12, 0.11), (-1.45, -0.25, 2.08)),
        *_guard_solids(),
    ]


def counterbalance_solids() -> list[OrientedBox]:
    """Return the collision boxes of the counterbalance truck at work."""
    return [
        *_mast_solids(COUNTERBALANCE_TOP),
        solid_box((1.83, 1.09, 0.55), (-1.095, 0.0, 0.275)),
        solid_box((0.32, 0.90, 0.65), (-0.46, 0.0, 0.72)),
        solid_box((1.09, 1.04, 0.55), (-1.465, 0.0, 0.71)),
        solid_box((0.60, 0.60, 0.66), (-1.29, 0.0, 1.10)),
        solid_box((1.0, 0.94, 0.08), (-1.07, 0.0, 2.0)),
        solid_box((0.40, 0.36, 0.66), (-0.72, 0.0, 0.92)),
        solid_box((0.12, 0.12, 0.11), (-1.45, -0.25, 2.08)),
        solid_box((0.14, 0.12, 0.12), (-1.95, 0.0, 0.45)),
        *_guard_solids(),
    ]


def _mast_solids(top: float) -> list[OrientedBox]:
    """Return the boxes of forks, carriage and mast of the counterbalance truck."""
    return [
        *fork_solids(top),
        solid_box((0.08, 1.0, 1.15), (-0.04, 0.0, top + 0.595)),
        solid_box((0.16, 0.74, FORKLIFT_HEIGHT - 0.06), (-0.16, 0.0, (FORKLIFT_HEIGHT + 0.06) / 2)),
    ]


def _guard_solids() -> list[OrientedBox]:
    """Return the boxes of its guard's posts and of its headlights."""
    solids = []
    for side in (-1.0, 1.0):
        solids.append(limb_box((-0.42, side * 0.47, 0.55), (-0.66, side * 0.44, 2.0), 0.04))
        solids.append(limb_box((-1.72, side * 0.43, 0.98), (-1.50, side * 0.42, 2.0), 0.04))
        solids.append(solid_box((0.1, 0.12, 0.12), (-0.46, side * 0.43, 1.36)))
    return solids


def reach_truck(name: str = "reach_truck") -> ObjectModel:
    """Build the reach truck with its mast drawn in: the driver sits sideways between the mast and the rear."""
    top = 0.30  # the blades lie above the wheel arms
    return assembled(name, "forklift", 178, _reach(top, fine=False), _reach_solids(top), 3300.0)


def reach_parts() -> list[Part]:
    """Return the reach truck at work, finely divided, with its forks over the wheel arms and a display."""
    return _reach(REACH_TOP, fine=True)


def _reach(top: float, fine: bool) -> list[Part]:
    """Return the reach truck whose blades have their top at ``top`` (m)."""
    solid, rolling = _style(fine)
    parts: list[Part] = [*fork_pair(top), *carriage(top, 0.8), *mast(Mast(REACH_HEIGHT, 0.74, -0.11, 3))]
    arm = ((-0.70, 0.06), (0.50, 0.06), (0.55, 0.12), (0.55, 0.17), (0.20, 0.22), (-0.70, 0.30))
    hull = ((-1.30, 0.10), (-0.34, 0.10), (-0.34, 0.98), (-0.62, 0.98), (-0.66, 0.42), (-1.30, 0.42))
    back = -1.32 if fine else -1.30
    rear = ((back, 0.40), (-1.06, 0.40), (-1.02, 1.02), (-1.10, 1.12), (back, 1.06))
    for side in (-1.0, 1.0):
        parts.append(solid(arm, 0.13, "truck_red", side * (REACH_WIDTH - 0.13) / 2, 0.05))
        parts += rolling((0.32, side * (REACH_WIDTH / 2 - 0.185), 0.1425), 0.285, 0.10)
    parts += [
        solid(hull, REACH_WIDTH - 0.02, "truck_red", 0.0, 0.06),
        solid(rear, REACH_WIDTH - 0.02, "truck_grey", 0.0, 0.10),
        box_part((0.26, REACH_WIDTH - 0.06, 0.40), (-0.49, 0.0, 0.70), "truck_grey"),
        box_part((0.40, 0.5, 0.42), (-0.86, 0.34, 0.62), "truck_grey"),
        box_part((0.20, 0.34, 0.16), (-0.55, -0.35, 1.06), "truck_grey"),
    ]
    if fine:
        parts.append(box_part((0.02, 0.22, 0.15), (-0.66, -0.05, 1.10), "guard_black"))  # display
    parts += rolling((-1.05, 0.30, 0.17), 0.34, 0.12) + _sideways_seat()
    posts = [((-0.38, 0.58, 0.90), (-0.42, 0.50, 2.15)), ((-1.24, 0.58, 1.0), (-1.20, 0.50, 2.15))]
    parts += overhead_guard(posts, (-1.20, -0.42, 0.50, 0.50), 2.19, "mast_black")
    return parts + steering((-0.62, -0.30, 0.90), (-0.72, -0.30, 1.16)) + beacon(-1.10, 0.30, 2.18)


def _style(fine: bool) -> tuple[Callable[[Outline, float, str, float, float], Part], Callable[..., list[Part]]]:
    """Return what makes bodies of side views, with rounded corners where finely divided, and what makes wheels."""
    if fine:
        return body, round_wheel
    return lambda outline, width, material, y, _: side_profile(outline, width, material, y), wheel


def _sideways_seat() -> list[Part]:
    """Return the seat of the reach truck: its back to the left side, looking to the right."""
    cushion, back = superellipsoid(5.0, 3.5, 24, 8), superellipsoid(4.0, 3.5, 24, 8)
    return [
        solid_part(cushion, (0.44, 0.46, 0.14), (-0.86, 0.30, 0.90), "mast_black"),
        solid_part(back, (0.44, 0.13, 0.56), (-0.86, 0.54, 1.16), "mast_black"),
    ]


def _reach_solids(top: float) -> list[OrientedBox]:
    """Return the collision boxes of the reach truck whose blades have their top at ``top`` (m)."""
    solids = fork_solids(top)
    solids += [
        solid_box((0.08, 0.8, 1.15), (-0.04, 0.0, top + 0.595)),
        solid_box((0.20, 0.74, REACH_HEIGHT - 0.06), (-0.19, 0.0, (REACH_HEIGHT + 0.06) / 2)),
        solid_box((0.96, REACH_WIDTH, 0.42), (-0.82, 0.0, 0.21)),
        solid_box((0.32, REACH_WIDTH, 0.60), (-0.50, 0.0, 0.70)),
        solid_box((0.30, REACH_WIDTH - 0.02, 0.74), (-1.15, 0.0, 0.76)),
        solid_box((0.48, 0.55, 1.06), (-0.86, 0.34, 0.92)),
        solid_box((0.46, 0.44, 0.36), (-0.66, -0.33, 1.10)),
        solid_box((0.86, 1.08, 0.08), (-0.81, 0.0, 2.15)),
        solid_box((0.12, 0.12, 0.11), (-1.10, 0.30, 2.23)),
    ]
    for side in (-1.0, 1.0):
        solids.append(solid_box((1.25, 0.13, 0.24), (-0.075, side * (REACH_WIDTH - 0.13) / 2, 0.18)))
        solids.append(solid_box((0.285, 0.12, 0.285), (0.32, side * (REACH_WIDTH / 2 - 0.185), 0.1425)))
        for x, head in ((-0.38, -0.42), (-1.24, -1.20)):
            solids.append(limb_box((x, side * 0.58, 0.90), (head, side * 0.50, 2.15), 0.04))
    return solids


def reach_truck_solids() -> list[OrientedBox]:
    """Return the collision boxes of the reach truck at work, its display included."""
    return [*_reach_solids(REACH_TOP), solid_box((0.04, 0.24, 0.17), (-0.66, -0.05, 1.10))]


def fork_solids(top: float) -> list[OrientedBox]:
    """Return the collision boxes of two fork arms whose blades have their top at ``top`` (m)."""
    solids = []
    for side in (-1.0, 1.0):
        y = side * FORK_SPREAD / 2
        blade = (FORK_LENGTH + FORK_THICKNESS, FORK_WIDTH, FORK_THICKNESS)
        solids.append(solid_box(blade, ((FORK_LENGTH - FORK_THICKNESS) / 2, y, top - FORK_THICKNESS / 2)))
        solids.append(solid_box((FORK_THICKNESS, FORK_WIDTH, 0.56), (-FORK_THICKNESS / 2, y, top + 0.28)))
    return solids


def pallet_jack(name: str = "pallet_jack") -> ObjectModel:
    """Build the hand pallet truck, lowered, its handle upright."""
    top, length = JACK_LOWERED, FORK_LENGTH
    tip = ((length - 0.10, 0.035), (length, 0.060), (length, 0.075), (length - 0.04, top))
    blade = ((-0.06, 0.035), *tip, (-0.06, top))
    bridge = ((-0.16, 0.05), (0.0, 0.05), (0.0, 0.085), (-0.05, 0.34), (-0.16, 0.36))
    parts: list[Part] = []
    for side in (-1.0, 1.0):
        y = side * JACK_SPREAD / 2
        parts.append(side_profile(blade, JACK_FORK, "truck_yellow", y))
        parts += wheel((length - 0.18, y, 0.041), 0.082, 0.07)
        parts += wheel((-0.22, side * 0.075, 0.10), 0.20, 0.05)
    parts += [
        side_profile(bridge, 2 * JACK_SPREAD / 2 + JACK_FORK, "truck_yellow"),
        mesh_part(rod((-0.22, 0.0, 0.12), (-0.22, 0.0, 0.46), 0.045), "truck_grey"),
        mesh_part(rod((-0.22, 0.0, 0.20), (-0.22, 0.0, 0.52), 0.025), "chrome"),
        box_part((0.10, 0.16, 0.10), (-0.24, 0.0, 0.32), "truck_yellow"),
        mesh_part(rod((-0.24, 0.0, 0.34), (-0.34, 0.0, 1.02), 0.018), "truck_yellow"),
    ]
    parts.append(mesh_part(_handle(), "rubber"))
    solids = [
        solid_box((0.18, JACK_SPREAD + JACK_FORK, 0.32), (-0.08, 0.0, 0.20)),
        solid_box((0.22, 0.21, 0.52), (-0.22, 0.0, 0.26)),
        limb_box((-0.24, 0.0, 0.34), (-0.34, 0.0, 1.02), 0.02),
        limb_box((-0.34, 0.0, 1.0), (-0.37, 0.0, 1.22), 0.02),
    ]
    solids[-1].size[1] = 0.36
    for side in (-1.0, 1.0):
        at = ((length - 0.06) / 2, side * JACK_SPREAD / 2, top / 2)
        solids.append(solid_box((length + 0.06, JACK_FORK, top), at))
    return assembled(name, "pallet_jack", 176, parts, solids, 68.0)


def _handle() -> TriangleMesh:
    """Return the closed loop of the handle."""
    turn = np.linspace(-0.5 * np.pi, 1.5 * np.pi, 25)
    # An ellipse stood on the rod's end and cut flat by its own thickness.
    path = np.column_stack([-0.355 - 0.02 * np.sin(turn), 0.16 * np.cos(turn), 1.12 + 0.10 * np.sin(turn)])
    return tube(path, [(0.015, 0.015)] * len(path), (1.0, 0.0, 0.2), 10)
