"""A selective rack along an aisle, on one side or both, and more racks behind it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, ClassVar, Literal

import numpy as np

from warehouse_sim.catalog.racks.pallet_racks import BAY_WIDTHS, FRAME_DEPTH
from warehouse_sim.catalog.racks.upright import HOLE_PITCH, UPRIGHT_WIDTH
from warehouse_sim.geometry.pose import Transform, make_transform, transform_points
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.scene.draft import HALF_TURN, Area, SceneDraft
from warehouse_sim.scene.layouts.rack import LOAD_CLEARANCE, Rack, build_rack, deck_strips, height_over_all
from warehouse_sim.scene.layouts.rack_fittings import add_row_spacers
from warehouse_sim.scene.layouts.site import Layout, Side, Slot

FLUE = 0.3
"""Free space between racks back to back (m); NFPA 13 requires 6 in (0.152 m) between the loads, which overhang."""


@dataclass(frozen=True)
@ranged
class RackAisleConfig(Layout):
    """Size of the rack and of the aisle in front of it."""

    kind: ClassVar[str] = "rack_aisle"

    bays: Annotated[int, Range(1, 12)] = 4
    """Bays on a side, 1-12."""
    beam_levels: Annotated[tuple[float, ...], Range(0.6, 12, "m")] = (1.45, 2.9)
    """Heights of the beams' tops above the floor (m), rising, each at least 0.6 above the one before, 0.6-12."""
    ground_level: bool = True
    """Whether pallets also stand on the floor inside the rack."""
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
        if not self.beam_levels and not self.ground_level:
            raise ValueError("beam_levels is empty and ground_level is false: no slot is left for a pallet")
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
    def length(self) -> float:
        """Extent along the aisle (m), between the outer frames' axes."""
        return self.bays * (self.bay_width + UPRIGHT_WIDTH)

    @property
    def depth(self) -> float:
        """Depth of all racks of a side (m)."""
        return self._row_front(self.rows_behind) + FRAME_DEPTH

    @property
    def tops(self) -> tuple[float, ...]:
        """Heights of the beams' tops (m)."""
        if not self.levels:
            return self.beam_levels
        return tuple(round(number * self.level_pitch / HOLE_PITCH) * HOLE_PITCH for number in range(1, self.levels + 1))

    def under(self, clear_height: float) -> "RackAisleConfig":
        """Return the rack with as many ``levels`` as leave room for the frames and the loads on top; at least one."""
        fitting = [top for top in self.tops if height_over_all(top) <= clear_height - LOAD_CLEARANCE]
        return replace(self, levels=max(1, len(fitting))) if self.levels else self

    def build_side(self, draft: SceneDraft, T_world_side: Transform, first_bay: int, rng: np.random.Generator) -> Side:
        """Add the racks; the places of the first are its slots, those of the others the backdrop."""
        rack = self._rack()
        slots = build_rack(draft, rack, T_world_side, first_bay, rng if self.tolerances else None)
        backdrop: list[Slot] = []
        for row in range(1, self.rows_behind + 1):
            front = self._row_front(row)
            turned = row % 2 == 1
            at = np.array([0.0, front + FRAME_DEPTH if turned else front, 0.0])
            T_side_rack = make_transform(HALF_TURN if turned else None, at)
            if turned:
                T_side_back = make_transform(translation=at - [0.0, FRAME_DEPTH + FLUE, 0.0])
                add_row_spacers(draft, rack.frames, rack.frame_height, T_world_side @ T_side_back)
            backdrop += build_rack(draft, rack, T_world_side @ T_side_rack, first_bay + row * 1000, None)
        return Side(
            slots=slots,
            backdrop=backdrop,
            strips=deck_strips(rack, T_world_side),
            aisles=self._side_aisles(T_world_side),
        )

    def _side_aisles(self, T_world_side: Transform) -> list[Area]:
        """Return the free floor between the racks behind: before each odd row but one that faces the wall."""
        half, areas = self.length / 2, []
        for row in range(1, self.rows_behind, 2):
            low, high = self._row_front(row) + FRAME_DEPTH, self._row_front(row + 1)
            ends = transform_points(T_world_side, np.array([[-half, low, 0.0], [half, high, 0.0]]))
            areas.append(Area(*np.sort(ends[:, 0]).tolist(), *np.sort(ends[:, 1]).tolist()))
        return areas

    def _rack(self) -> Rack:
        """Return the drawing that all rows share."""
        return Rack(
            bays=self.bays,
            levels=self.tops,
            ground_level=self.ground_level,
            bay_width=self.bay_width,
            places=self._places(),
            beams=self.beams,
            mesh_decks=self.mesh_decks,
            guards=self.guards,
            support_bars=self.support_bars,
            signs=self.signs,
            bay_load=np.inf if self.bay_load is None else self.bay_load,
        )

    def _row_front(self, row: int) -> float:
        """Return y (m) of the nearer face of a row, 0 = the one along the aisle."""
        pairs, second = divmod(row, 2)
        return pairs * (2 * FRAME_DEPTH + FLUE + self.aisle_width) + second * (FRAME_DEPTH + FLUE)

    def _places(self) -> Sequence[float]:
        """Return x of each pallet in a bay, from the bay's middle (m): equal gaps to uprights and between pallets."""
        count = self.pallets_per_bay
        pitch = self.pallet_width + (self.bay_width - count * self.pallet_width) / (count + 1)
        return [float(x) for x in (np.arange(count) - (count - 1) / 2) * pitch]
