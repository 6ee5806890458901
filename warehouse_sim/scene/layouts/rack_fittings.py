"""What hangs on a rack or stands before it: guards, load notices, labels of beams and uprights.

Frame of a rack: x along the aisle, y into the rack, z up; its front is the plane y = 0, its middle x = 0.
"""

from collections.abc import Sequence

import numpy as np

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.racks.pallet_racks import BEAM_HEIGHT, FRAME_DEPTH
from warehouse_sim.catalog.racks.upright import UPRIGHT_WIDTH
from warehouse_sim.geometry.pose import Transform, make_transform
from warehouse_sim.scene.draft import HALF_TURN, QUARTER_TURN, SceneDraft
from warehouse_sim.schema import ObjectModel

_GUARD_GAP = 0.05
"""Free space between a guard and the rack (m)."""
_OFF = 0.001
"""Free space behind a plate (m), so that it shares no plane with what it hangs on, plumb or not."""
_EYES, _LOWEST = 1.75, 0.9
"""Height of the middle of a load notice, and least height of a bay's number (m)."""


def add_guards(draft: SceneDraft, xs: Sequence[float], T_world_rack: Transform) -> None:
    """Add a barrier across each end of the rack and a guard before each front upright; ``xs`` are its frames' (m)."""
    barrier = catalog_object("rack_end_guard")
    for side in (-1.0, 1.0):
        x = side * (xs[-1] + UPRIGHT_WIDTH / 2 + _GUARD_GAP + barrier.size[0])
        T_rack_barrier = make_transform(None if side > 0 else HALF_TURN, np.array([x, FRAME_DEPTH / 2, 0.0]))
        T_rack_barrier[2, 3] = barrier.size[2] / 2
        draft.add("rack_end_guard", T_world_rack @ T_rack_barrier)
    add_upright_guards(draft, xs, T_world_rack)


def add_upright_guards(draft: SceneDraft, xs: Sequence[float], T_world_rack: Transform) -> None:
    """Add a guard before each front upright, whose axes are at ``xs`` (m) along the rack."""
    guard = catalog_object("upright_guard")
    for x in xs:
        draft.put("upright_guard", (x, -guard.size[1] / 2 - _GUARD_GAP, guard.size[2] / 2), T_world_rack)


def add_frame_signs(
    draft: SceneDraft, levels: Sequence[float], T_world_feet: Sequence[Transform], notice: ObjectModel
) -> None:
    """Hang the load notice on both end frames, facing outwards, and a bay's number on each front upright.

    Args:
        draft: Where to add them.
        levels: Heights of the beams' tops (m); numbers hang between them.
        T_world_feet: Middle of each frame's foot, from one end to the other; y into the rack, z along the frame.
        notice: The load notice, which says what the rack's levels carry.
    """
    number = catalog_object("frame_label")
    half = UPRIGHT_WIDTH / 2 + _OFF + notice.size[1] / 2
    for T_world_foot, side, rotation in (
        (T_world_feet[0], -1.0, QUARTER_TURN.T),
        (T_world_feet[-1], 1.0, QUARTER_TURN),
    ):
        draft.put(notice, (side * half, 0.0, _EYES), T_world_foot, rotation=rotation)
    # Connectors cover the upright beside each beam, from its top down.
    free = [z for z in np.arange(_LOWEST, _EYES, 0.05) if all(not top - 0.3 < z < top + 0.1 for top in levels)]
    at = np.array([0.0, -FRAME_DEPTH / 2 - number.size[1] / 2 - _OFF, max(free, default=_LOWEST)])
    for T_world_foot in T_world_feet:
        draft.add("frame_label", T_world_foot @ make_transform(translation=at))


def add_row_spacers(draft: SceneDraft, xs: Sequence[float], height: float, T_world_back: Transform) -> None:
    """Tie racks back to back at a lower and an upper height.

    Args:
        draft: Where to add the ties.
        xs: x of the frames (m).
        height: Of the frames (m).
        T_world_back: Middle of the back of the rack nearer to the aisle, on the floor; y to the other rack.
    """
    length = catalog_object("row_spacer").size[1]
    for x in xs:
        for z in (0.9, height - 0.6):
            draft.put("row_spacer", (x, length / 2, z), T_world_back)


def add_beam_labels(draft: SceneDraft, places: Sequence[float], T_world_face: Transform) -> None:
    """Stick a location's label on a front beam under each place.

    Args:
        draft: Where to add them.
        places: x of each place from the beam's middle (m).
        T_world_face: Upper edge of the beam's front face at its middle; y into the beam, z up.
    """
    label = catalog_object("beam_label")
    for x in places:
        draft.put("beam_label", (x, -label.size[1] / 2 - _OFF, -BEAM_HEIGHT / 2), T_world_face)
