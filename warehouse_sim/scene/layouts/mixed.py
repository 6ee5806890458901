"""Two kinds of storage face to face across one aisle."""

from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np

from warehouse_sim.geometry.pose import Transform
from warehouse_sim.ranges import ranged
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.layouts.block_storage import BlockStorageConfig
from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig
from warehouse_sim.scene.layouts.site import Layout, Side


@dataclass(frozen=True)
@ranged
class MixedConfig(Layout):
    """What stands on each side of the aisle; only the settings of one side count of each, not its own aisle."""

    kind: ClassVar[str] = "mixed"

    front: Layout = field(default_factory=RackAisleConfig)
    """Layout of the front side, any kind but mixed."""
    back: Layout = field(default_factory=BlockStorageConfig)
    """Layout of the side opposite, any kind but mixed."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if isinstance(self.front, MixedConfig) or isinstance(self.back, MixedConfig):
            raise ValueError("front and back must be single layouts, not mixed again")
        if self.back.door_modules:
            raise ValueError("dock doors are in the wall behind the front; make dock_staging the front")

    @property
    def extent(self) -> tuple[float, float]:
        """That of the front (m)."""
        return self.front.extent

    @property
    def gap(self) -> float:
        """Free space between the front and the wall behind it (m)."""
        return self.front.gap

    @property
    def door_modules(self) -> tuple[int, ...]:
        """Those of the front."""
        return self.front.door_modules

    @property
    def opposite(self) -> Layout:
        """The back."""
        return self.back

    @property
    def wants_goods(self) -> bool:
        """Whether a side does."""
        return self.front.wants_goods or self.back.wants_goods

    def under(self, clear_height: float) -> "MixedConfig":
        """Return both sides as they fit the hall."""
        return replace(self, front=self.front.under(clear_height), back=self.back.under(clear_height))

    def build_side(self, draft: SceneDraft, T_world_side: Transform, first_bay: int, rng: np.random.Generator) -> Side:
        """Add the front."""
        return self.front.build_side(draft, T_world_side, first_bay, rng)
