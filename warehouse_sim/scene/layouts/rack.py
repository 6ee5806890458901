"""One selective rack: frames, beams, decks and bars, and the places for pallets that they make.

Frame of a rack: x along the aisle, y into the rack, z up; its front is the plane y = 0, its middle x = 0.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.pallets import HEIGHT as PALLET_HEIGHT
from warehouse_sim.catalog.racks.accessories import DECK_DEPTH, DECK_WIDTH, load_notice_of
from warehouse_sim.catalog.racks.pallet_racks import (
    BEAM_DEPTH,
    BEAM_HEIGHT,
    CONNECTOR_HEIGHT,
    FRAME_DEPTH,
    FRAME_HEIGHTS,
    STEP_BEAM_DEPTH,
    STEP_HEIGHT,
    beam_pose,
    frame_pose,
)
from warehouse_sim.catalog.racks.upright import UPRIGHT_WIDTH
from warehouse_sim.geometry.pose import Transform, make_transform, transform_points
from warehouse_sim.scene.draft import QUARTER_TURN, SceneDraft
from warehouse_sim.scene.layouts.rack_fittings import add_beam_labels, add_frame_signs, add_guards
from warehouse_sim.scene.layouts.site import Slot, Strip
from warehouse_sim.schema import ObjectModel

LOAD_CLEARANCE = 0.1
"""Free height between a load and the beam above it (m)."""
_HEADROOM_ABOVE_TOP = 1.3
"""Height that a load on the top level may take, pallet included (m)."""
_FRAME_OVER_TOP_BEAM = 0.5
"""End frames rise at least this far above the top beam (m)."""
_BAR = 0.28
"""Distance of a support bar from the middle of its pallet (m)."""
_REACH = 0.5
"""How far to both sides of its middle a pallet may lie on a beam (m)."""
_HALF_TURN = QUARTER_TURN @ QUARTER_TURN


@dataclass(frozen=True)
class Rack:
    """Drawing of a rack."""

    bays: int
    levels: tuple[float, ...]
    """Heights of the beams' tops (m), rising."""
    ground_level: bool
    """Whether pallets also stand on the floor."""
    bay_width: float
    """Clear width between frames (m)."""
    places: Sequence[float]
    """x of each pallet from the middle of its bay (m)."""
    beams: str
    """"box" or "step"."""
    mesh_decks: bool
    guards: bool
    support_bars: bool = False
    """Whether two bars lie under each place; with step beams and without decks."""
    signs: bool = False
    """Whether load notices hang at the ends and labels on beams and uprights."""
    bay_load: float = np.inf
    """What a level of a bay may carry (kg)."""

    @property
    def pitch(self) -> float:
        """Distance between the axes of neighbouring frames (m)."""
        return self.bay_width + UPRIGHT_WIDTH

    @property
    def frames(self) -> list[float]:
        """Places of the frames' axes along x (m)."""
        return [(index - self.bays / 2) * self.pitch for index in range(self.bays + 1)]

    @property
    def frame_height(self) -> float:
        """Height of the frames (m)."""
        return _frame_above(max(self.levels, default=1.0))[1]

    @property
    def notice(self) -> ObjectModel:
        """The load notice: what a level, a bay and a pallet may weigh."""
        if np.isinf(self.bay_load):
            return catalog_object("load_notice")
        return load_notice_of(int(self.bay_load), len(self.levels), len(self.places))


def build_rack(
    draft: SceneDraft, rack: Rack, T_world_rack: Transform, first_bay: int, rng: np.random.Generator | None
) -> list[Slot]:
    """Add one rack and return its slots, bay by bay.

    Args:
        draft: Where to add it.
        rack: Its drawing.
        T_world_rack: Its frame.
        first_bay: Number of its first bay.
        rng: Where deviations from the drawing come from; None builds exactly what is sampled.
    """
    T_world_feet = _add_frames(draft, rack, T_world_rack, rng)
    levels = ([0.0] if rack.ground_level else []) + list(rack.levels)
    slots: list[Slot] = []
    for bay in range(rack.bays):
        x = (bay - (rack.bays - 1) / 2) * rack.pitch
        for number, level in enumerate(levels):
            tops = _add_level(draft, rack, T_world_rack, x, level, rng) if level > 0.0 else []
            above = [other for other in rack.levels if other > level]
            free = above[0] - BEAM_HEIGHT - LOAD_CLEARANCE - level if above else _HEADROOM_ABOVE_TOP
            if free >= PALLET_HEIGHT:
                slots += _slots(T_world_rack, rack, x, level, free, tops, first_bay + bay * len(levels) + number)
    if rack.guards:
        add_guards(draft, rack.bays, rack.pitch, T_world_rack)
    if rack.signs:
        add_frame_signs(draft, rack.levels, T_world_feet, rack.notice)
    return slots


def deck_strips(rack: Rack, T_world_rack: Transform) -> list[Strip]:
    """Return what the decks of a rack offer to things without a pallet, bay by bay; nothing without decks."""
    if not rack.mesh_decks:
        return []
    y, length = (FRAME_DEPTH - DECK_DEPTH) / 2, rack.bay_width - UPRIGHT_WIDTH
    xs = [(bay - (rack.bays - 1) / 2) * rack.pitch for bay in range(rack.bays)]
    return [
        Strip(T_world_rack @ make_transform(translation=np.array([x, y, top])), length, DECK_DEPTH, 1.0)
        for x in xs
        for top in rack.levels
    ]


def height_over_all(top: float) -> float:
    """Return how high (m) a rack whose highest beam's top is at ``top`` (m) reaches with its frames and loads."""
    return max(_frame_above(top)[1], top + _HEADROOM_ABOVE_TOP)


def _frame_above(top: float) -> tuple[str, float]:
    """Return name and height (m) of the lowest frame that carries a beam at ``top`` (m)."""
    return next(
        ((name, height) for name, height in FRAME_HEIGHTS.items() if height >= top + _FRAME_OVER_TOP_BEAM),
        list(FRAME_HEIGHTS.items())[-1],
    )


def _add_frames(
    draft: SceneDraft, rack: Rack, T_world_rack: Transform, rng: np.random.Generator | None
) -> list[Transform]:
    """Add the frames; return T_world_foot of each."""
    name, height = _frame_above(max(rack.levels, default=1.0))
    T_frame_foot = make_transform(translation=np.array([0.0, 0.0, -height / 2]))
    feet = []
    for x in rack.frames:
        at = np.array([x, FRAME_DEPTH / 2, height / 2])
        T_nominal_frame = np.eye(4) if rng is None else frame_pose(height, rng)
        frame = draft.add(name, T_world_rack @ make_transform(translation=at) @ T_nominal_frame)
        feet.append(frame.T_world_object @ T_frame_foot)
    return feet


def _add_level(
    draft: SceneDraft, rack: Rack, T_world_rack: Transform, x: float, top: float, rng: np.random.Generator | None
) -> list[Transform]:
    """Add the two beams of a bay's level and what lies on them; return T_rack_top of their upper faces."""
    step = rack.beams == "step"
    name = f"{rack.beams.replace('box', 'rack')}_beam_{round(1000 * rack.bay_width)}"
    depth = STEP_BEAM_DEPTH if step else BEAM_DEPTH
    # A step beam's connectors reach around the front of the uprights.
    y_front = depth / 2 - (STEP_BEAM_DEPTH - BEAM_DEPTH) * step
    tops = []
    for y, rotation in ((y_front, None), (FRAME_DEPTH - y_front, _HALF_TURN if step else None)):
        at = np.array([x, y, top - CONNECTOR_HEIGHT / 2])
        T_rack_beam = make_transform(rotation, at)
        if rng is not None:
            T_rack_beam = T_rack_beam @ beam_pose(rack.bay_width, rng)
        draft.add(name, T_world_rack @ T_rack_beam)
        tops.append(T_rack_beam @ make_transform(translation=np.array([0.0, 0.0, CONNECTOR_HEIGHT / 2])))
    if rack.mesh_decks:
        count = int(rack.bay_width / DECK_WIDTH)
        for index in range(count):
            at = np.array([x + (index - (count - 1) / 2) * rack.bay_width / count, FRAME_DEPTH / 2, top])
            at[2] -= STEP_HEIGHT / 2
            draft.add("mesh_deck", T_world_rack @ make_transform(translation=at))
    elif rack.support_bars and step:
        for place in rack.places:
            for side in (-_BAR, _BAR):
                at = np.array([x + place + side, FRAME_DEPTH / 2, top - STEP_HEIGHT / 2])
                draft.add("pallet_support_bar", T_world_rack @ make_transform(translation=at))
    if rack.signs:
        T_world_face = T_world_rack @ tops[0] @ make_transform(translation=np.array([0.0, -BEAM_DEPTH / 2, 0.0]))
        add_beam_labels(draft, rack.places, T_world_face)
    return tops


def _slots(
    T_world_rack: Transform, rack: Rack, x: float, z: float, headroom: float, tops: list[Transform], bay: int
) -> list[Slot]:
    return [
        Slot(
            T_world_rack
            @ make_transform(QUARTER_TURN, np.array([x + dx, FRAME_DEPTH / 2, _support_height(z, tops, x + dx)])),
            headroom,
            bay,
            most_mass=np.inf if z == 0.0 else rack.bay_load / len(rack.places),
        )
        for dx in rack.places
    ]


def _support_height(nominal: float, tops: list[Transform], x: float) -> float:
    """Return the highest point (m) of the beams under a pallet at ``x``: beams are neither level nor straight."""
    ends: Float[np.ndarray, "4 3"] = np.array(
        [[dx, dy, 0.0] for dx in (-_REACH, _REACH) for dy in (-BEAM_DEPTH / 2, BEAM_DEPTH / 2)]
    )
    heights = [nominal]
    for T_rack_top in tops:
        along = T_rack_top[0, 0] * (x - T_rack_top[0, 3])
        heights.append(float(transform_points(T_rack_top, ends + np.array([along, 0.0, 0.0]))[:, 2].max()))
    return max(heights)
