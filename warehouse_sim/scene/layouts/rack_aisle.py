"""A selective rack along an aisle, on one side or both."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

import numpy as np

from warehouse_sim.catalog.racks import BAY_WIDTHS, FRAME_DEPTH, UPRIGHT_WIDTH
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.layouts.rack import Rack, build_rack
from warehouse_sim.scene.layouts.site import Layout, Side


@dataclass(frozen=True)
@ranged
class RackAisleConfig(Layout):
    """Size of the rack and of the aisle in front of it."""

    kind: ClassVar[str] = "rack_aisle"

    bays: Annotated[int, Range(1, 12)] = 4
    """Bays on a side, 1-12."""
    beam_levels: Annotated[tuple[float, ...], Range(0.6, 6, "m")] = (1.45, 2.9)
    """Heights of the beams' tops above the floor (m), rising, each at least 0.6 above the one before, 0.6-6."""
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

    def __post_init__(self) -> None:
        if np.diff(self.beam_levels).min(initial=np.inf) < 0.6:
            raise ValueError(f"beam_levels must rise by at least 0.6 m each, found {list(self.beam_levels)}")
        if not self.beam_levels and not self.ground_level:
            raise ValueError("beam_levels is empty and ground_level is false: no slot is left for a pallet")
        if self.bay_width not in BAY_WIDTHS.values():
            raise ValueError(f"bay_width must be one of {sorted(BAY_WIDTHS.values())} m, found {self.bay_width}")
        if self.pallets_per_bay * self.pallet_width > self.bay_width - 0.05 * (self.pallets_per_bay + 1):
            raise ValueError(
                f"{self.pallets_per_bay} pallets of {self.pallet_width} m need gaps of 0.05 m beyond bay_width "
                f"{self.bay_width} m; take fewer pallets_per_bay"
            )
        if self.mesh_decks and (self.beams != "step" or self.bay_width == min(BAY_WIDTHS.values())):
            raise ValueError("mesh_decks need step beams (beams: step) and a bay_width of 2.7 or 3.6 m")

    @property
    def length(self) -> float:
        """Extent along the aisle (m), between the outer frames' axes."""
        return self.bays * (self.bay_width + UPRIGHT_WIDTH)

    @property
    def depth(self) -> float:
        """Depth of a rack (m)."""
        return FRAME_DEPTH

    @property
    def opposite(self) -> "RackAisleConfig | None":
        """The same rack again, when there are two."""
        return self if self.sides == "both" else None

    def build_side(self, draft: SceneDraft, T_world_side: Transform, first_bay: int, rng: np.random.Generator) -> Side:
        """Add the rack; its places are its slots."""
        rack = Rack(
            bays=self.bays,
            levels=self.beam_levels,
            ground_level=self.ground_level,
            bay_width=self.bay_width,
            places=self._places(),
            beams=self.beams,
            mesh_decks=self.mesh_decks,
            guards=self.guards,
        )
        return Side(slots=build_rack(draft, rack, T_world_side, first_bay, rng if self.tolerances else None))

    def _places(self) -> Sequence[float]:
        """Return x of each pallet in a bay, from the bay's middle (m): equal gaps to uprights and between pallets."""
        count = self.pallets_per_bay
        pitch = self.pallet_width + (self.bay_width - count * self.pallet_width) / (count + 1)
        return [float(x) for x in (np.arange(count) - (count - 1) / 2) * pitch]
