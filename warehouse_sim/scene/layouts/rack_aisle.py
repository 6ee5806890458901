"""A selective rack along an aisle, on one side or both, and more racks behind it.

Frame of a rack: x along the aisle, y into the rack, z up; its front is the plane y = 0, its middle x = 0.
"""

from dataclasses import dataclass, replace
from typing import Annotated, ClassVar, Literal

import numpy as np
from jaxtyping import Float

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.pallets import HEIGHT as PALLET_HEIGHT
from warehouse_sim.catalog.racks.accessories import DECK_DEPTH, DECK_WIDTH, load_notice_of
from warehouse_sim.catalog.racks.pallet_racks import (
    BAY_WIDTHS,
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
from warehouse_sim.catalog.racks.upright import HOLE_PITCH, UPRIGHT_WIDTH
from warehouse_sim.geometry.pose import Transform, make_transform, transform_points
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.scene.draft import HALF_TURN, QUARTER_TURN, Area, SceneDraft
from warehouse_sim.scene.layouts.rack_fittings import add_beam_labels, add_frame_signs, add_guards, add_row_spacers
from warehouse_sim.scene.layouts.site import Layout, Side, Slot, Strip

FLUE = 0.3
"""Free space between racks back to back (m); NFPA 13 requires 6 in (0.152 m) between the loads, which overhang."""
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


@dataclass(frozen=True)
@ranged
class RackAisleConfig(Layout):
    """Size of the rack and of the aisle in front of it."""

    kind: ClassVar[str] = "rack_aisle"

    bays: Annotated[int, Range(1, 12)] = 4
    """Bays on a side, 1-12."""
    beam_levels: Annotated[tuple[float, ...], Range(0.6, 12, "m")] = (1.45, 2.9)
    """Heights of the beams' tops above the floor (m), rising, each at least 0.6 above the one before, 0.6-12."""
    sides: Literal["one", "both"] = "one"
    """Racks on one side of the aisle, with a wall behind, or on both."""
    bay_width: Annotated[float, Range(1.825, 3.6, "m")] = 2.7
    """Clear width of a bay (m), 1.825-3.6: 1.825, 2.7 or 3.6."""
    pallets_per_bay: Annotated[int, Range(1, 4)] = 3
    """Pallets side by side in a bay, 1-4."""
    pallet_width: Annotated[float, Range(0.4, 1.3, "m")] = 0.8
    """Width that the places of a bay are made for (m), 0.4-1.3; what is left is split into equal gaps."""
    beams: Literal["box", "step"] = "box"
    """Plain beams or step beams; step beams can carry decks."""
    mesh_decks: bool = False
    """Whether wire decks lie on the beams, which must be step beams."""
    guards: bool = False
    """Whether the rack has guards at its ends and before its uprights."""
    tolerances: bool = False
    """Whether frames and beams are off their drawing as far as EN 15620 allows."""
    levels: Annotated[int, Range(0, 7)] = 0
    """Beam levels at equal distances, 0-7, as many of them as fit under the roof; 0 = those of ``beam_levels``."""
    level_pitch: Annotated[float, Range(0.8, 3, "m")] = 1.5
    """Distance from beam level to beam level (m) where ``levels`` is given, rounded to 50 mm, 0.8-3."""
    bay_load: Annotated[float, Range(300, 12_000, "kg")] | None = None
    """What the load notice allows a level of a bay (kg), 300-12,000; null = what the pallets carry."""
    support_bars: bool = False
    """Whether two bars lie under each pallet where there is no deck; they need step beams."""
    signs: bool = False
    """Whether load notices, labels of the places and numbers of the bays hang on the rack."""
    rows_behind: Annotated[int, Range(0, 8)] = 0
    """Racks behind the first, 0-8: back to back with it, then across the next aisle, and so on; on both sides."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if np.diff(self.beam_levels).min(initial=np.inf) < 0.6:
            raise ValueError(f"beam_levels must rise by at least 0.6 m each, found {list(self.beam_levels)}")
        if self.bay_width not in BAY_WIDTHS:
            raise ValueError(f"bay_width must be one of {list(BAY_WIDTHS)} m, found {self.bay_width}")
        if self.pallets_per_bay * self.pallet_width > self.bay_width - 0.05 * (self.pallets_per_bay + 1):
            raise ValueError(
                f"{self.pallets_per_bay} pallets of {self.pallet_width} m need gaps of 0.05 m beyond bay_width "
                f"{self.bay_width} m; take fewer pallets_per_bay"
            )
        if self.support_bars and self.beams != "step":
            raise ValueError("support_bars need step beams (beams: step)")
        if self.mesh_decks and (self.beams != "step" or self.bay_width == BAY_WIDTHS[0]):
            raise ValueError("mesh_decks need step beams (beams: step) and a bay_width of 2.7 or 3.6 m")

    @property
    def pitch(self) -> float:
        """Distance between the axes of neighbouring frames (m)."""
        return self.bay_width + UPRIGHT_WIDTH

    @property
    def extent(self) -> tuple[float, float]:
        """Along the aisle between the outer frames' axes, and the depth of all racks of a side (m)."""
        return self.bays * self.pitch, self._row_front(self.rows_behind) + FRAME_DEPTH

    @property
    def tops(self) -> tuple[float, ...]:
        """Heights of the beams' tops (m), rising."""
        if not self.levels:
            return self.beam_levels
        return tuple(round(number * self.level_pitch / HOLE_PITCH) * HOLE_PITCH for number in range(1, self.levels + 1))

    @property
    def frames(self) -> list[float]:
        """Places of the frames' axes along x (m)."""
        return [(index - self.bays / 2) * self.pitch for index in range(self.bays + 1)]

    @property
    def places(self) -> list[float]:
        """X of each pallet in a bay, from the bay's middle (m): equal gaps to uprights and between pallets."""
        count = self.pallets_per_bay
        pitch = self.pallet_width + (self.bay_width - count * self.pallet_width) / (count + 1)
        return [float(x) for x in (np.arange(count) - (count - 1) / 2) * pitch]

    def under(self, clear_height: float) -> "RackAisleConfig":
        """Return the rack with as many ``levels`` as leave room for the frames and the loads on top; at least one."""
        free = clear_height - LOAD_CLEARANCE
        fitting = [top for top in self.tops if max(_frame_above(top)[1], top + _HEADROOM_ABOVE_TOP) <= free]
        return replace(self, levels=max(1, len(fitting))) if self.levels else self

    def build_side(self, draft: SceneDraft, T_world_side: Transform, first_bay: int, rng: np.random.Generator) -> Side:
        """Add the racks; the places of the first are its slots, those of the others the backdrop."""
        slots = _build_rack(draft, self, T_world_side, first_bay, rng if self.tolerances else None)
        backdrop: list[Slot] = []
        for row in range(1, self.rows_behind + 1):
            front = self._row_front(row)
            turned = row % 2 == 1
            at = np.array([0.0, front + FRAME_DEPTH if turned else front, 0.0])
            T_side_rack = make_transform(HALF_TURN if turned else None, at)
            if turned:
                T_side_back = make_transform(translation=at - [0.0, FRAME_DEPTH + FLUE, 0.0])
                _, height = _frame_above(max(self.tops, default=1.0))
                add_row_spacers(draft, self.frames, height, T_world_side @ T_side_back)
            backdrop += _build_rack(draft, self, T_world_side @ T_side_rack, first_bay + row * 1000, None)
        strips, aisles = self._deck_strips(T_world_side), self._side_aisles(T_world_side)
        return Side(slots=slots, backdrop=backdrop, strips=strips, side_aisles=aisles)

    def bay_x(self, bay: int) -> float:
        """Return x of the middle of a bay (m)."""
        return (bay - (self.bays - 1) / 2) * self.pitch

    def _deck_strips(self, T_world_side: Transform) -> list[Strip]:
        """Return what the decks offer to things without a pallet, bay by bay; nothing without decks."""
        y, length = (FRAME_DEPTH - DECK_DEPTH) / 2, self.bay_width - UPRIGHT_WIDTH
        return [
            Strip(
                T_world_side @ make_transform(translation=np.array([self.bay_x(bay), y, top])), length, DECK_DEPTH, 1.0
            )
            for bay in range(self.bays if self.mesh_decks else 0)
            for top in self.tops
        ]

    def _side_aisles(self, T_world_side: Transform) -> list[Area]:
        """Return the free floor between the racks behind: before each odd row but one that faces the wall."""
        half, areas = self.length / 2, []
        for row in range(1, self.rows_behind, 2):
            low, high = self._row_front(row) + FRAME_DEPTH, self._row_front(row + 1)
            ends = transform_points(T_world_side, np.array([[-half, low, 0.0], [half, high, 0.0]]))
            areas.append(Area(*np.sort(ends[:, 0]).tolist(), *np.sort(ends[:, 1]).tolist()))
        return areas

    def _row_front(self, row: int) -> float:
        """Return y (m) of the nearer face of a row, 0 = the one along the aisle."""
        pairs, second = divmod(row, 2)
        return pairs * (2 * FRAME_DEPTH + FLUE + self.aisle_width) + second * (FRAME_DEPTH + FLUE)


def _build_rack(
    draft: SceneDraft, rack: RackAisleConfig, T_world_rack: Transform, first_bay: int, rng: np.random.Generator | None
) -> list[Slot]:
    """Add one rack and return its slots, bay by bay.

    Args:
        draft: Where to add it.
        rack: Its drawing.
        T_world_rack: Its frame.
        first_bay: Number of its first bay.
        rng: Where deviations from the drawing come from; None builds exactly what is drawn.
    """
    T_world_feet = _add_frames(draft, rack, T_world_rack, rng)
    levels = [0.0, *rack.tops]
    slots: list[Slot] = []
    for bay in range(rack.bays):
        x = rack.bay_x(bay)
        for number, level in enumerate(levels):
            tops = _add_level(draft, rack, T_world_rack, x, level, rng) if level > 0.0 else []
            above = [other for other in rack.tops if other > level]
            free = above[0] - BEAM_HEIGHT - LOAD_CLEARANCE - level if above else _HEADROOM_ABOVE_TOP
            if free >= PALLET_HEIGHT:
                slots += _slots(T_world_rack, rack, x, level, free, tops, first_bay + bay * len(levels) + number)
    if rack.guards:
        add_guards(draft, rack.frames, T_world_rack)
    if rack.signs:
        load = rack.bay_load
        notice = load_notice_of(int(load), len(rack.tops), len(rack.places)) if load else catalog_object("load_notice")
        add_frame_signs(draft, rack.tops, T_world_feet, notice)
    return slots


def _frame_above(top: float) -> tuple[str, float]:
    """Return name and height (m) of the lowest frame that carries a beam at ``top`` (m)."""
    return next(
        ((name, height) for name, height in FRAME_HEIGHTS.items() if height >= top + _FRAME_OVER_TOP_BEAM),
        list(FRAME_HEIGHTS.items())[-1],
    )


def _add_frames(
    draft: SceneDraft, rack: RackAisleConfig, T_world_rack: Transform, rng: np.random.Generator | None
) -> list[Transform]:
    """Add the frames; return T_world_foot of each."""
    name, height = _frame_above(max(rack.tops, default=1.0))
    T_frame_foot = make_transform(translation=np.array([0.0, 0.0, -height / 2]))
    feet = []
    for x in rack.frames:
        at = np.array([x, FRAME_DEPTH / 2, height / 2])
        T_nominal_frame = np.eye(4) if rng is None else frame_pose(height, rng)
        frame = draft.add(name, T_world_rack @ make_transform(translation=at) @ T_nominal_frame)
        feet.append(frame.T_world_object @ T_frame_foot)
    return feet


def _add_level(
    draft: SceneDraft,
    rack: RackAisleConfig,
    T_world_rack: Transform,
    x: float,
    top: float,
    rng: np.random.Generator | None,
) -> list[Transform]:
    """Add the two beams of a bay's level and what lies on them; return T_rack_top of their upper faces."""
    step = rack.beams == "step"
    name = f"{rack.beams.replace('box', 'rack')}_beam_{round(1000 * rack.bay_width)}"
    depth = STEP_BEAM_DEPTH if step else BEAM_DEPTH
    # A step beam's connectors reach around the front of the uprights.
    y_front = depth / 2 - (STEP_BEAM_DEPTH - BEAM_DEPTH) * step
    tops = []
    for y, rotation in ((y_front, None), (FRAME_DEPTH - y_front, HALF_TURN if step else None)):
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
                draft.put(
                    "pallet_support_bar", (x + place + side, FRAME_DEPTH / 2, top - STEP_HEIGHT / 2), T_world_rack
                )
    if rack.signs:
        T_world_face = T_world_rack @ tops[0] @ make_transform(translation=np.array([0.0, -BEAM_DEPTH / 2, 0.0]))
        add_beam_labels(draft, rack.places, T_world_face)
    return tops


def _slots(
    T_world_rack: Transform, rack: RackAisleConfig, x: float, z: float, headroom: float, tops: list[Transform], bay: int
) -> list[Slot]:
    return [
        Slot(
            T_world_rack
            @ make_transform(QUARTER_TURN, np.array([x + dx, FRAME_DEPTH / 2, _support_height(z, tops, x + dx)])),
            headroom,
            bay,
            most_mass=np.inf if z == 0.0 or rack.bay_load is None else rack.bay_load / len(rack.places),
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
