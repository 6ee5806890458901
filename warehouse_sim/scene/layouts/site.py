"""What a layout leaves for others to fill: places in racks and on conveyors, floor lanes, and the aisle.

World: the aisle runs along x, centred on x = 0; what stands on its front side begins at the plane y = 0 and extends to
positive y; the aisle is the strip from y = -width to 0. The floor is z = 0.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, fields
from itertools import chain
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np

from warehouse_sim.catalog.building.shell import FLOOR_SIZE, WALL_SIZE
from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import ConfigError, PlacementError, shown, suggestion
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, make_transform
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.scene.building.floor import add_tyre_marks
from warehouse_sim.scene.building.hall import HallConfig, build_hall
from warehouse_sim.scene.draft import HALF_TURN, Area, SceneDraft

_COLUMN_GAP = 0.65
"""Free space behind a side with columns (m)."""
_FOOTPRINT = (1.2, 0.8)
"""Edges of a pallet (m) where a slot does not say."""


Truck = Literal["any", "counterbalance", "reach", "very_narrow", "pallet_jack"]
"""What works in an aisle."""
AISLES: dict[Truck, tuple[float, float]] = {
    "any": (1.5, 15.0),
    "counterbalance": (3.5, 4.2),
    "reach": (2.7, 3.0),
    "very_narrow": (1.6, 1.9),
    "pallet_jack": (2.0, 2.4),
}
"""Least and greatest width (m) of the aisle that each truck works in with EPAL 1 pallets, after the working aisle
widths of makers' data sheets (VDI 2198): counterbalanced truck, reach truck, man-up turret truck, hand pallet truck."""


@dataclass(frozen=True, eq=False)
class Slot:
    """A place for one pallet, short side out."""

    T_world_slot: Transform
    """On the supporting surface under the pallet's centre; x into the rack, z up."""
    headroom: float
    """Height from the supporting surface that the load may take, pallet included (m)."""
    bay: int
    """Number of the bay and level; slots of one bay are neighbours."""
    footprint: tuple[float, float] | None = None
    """Greatest edges of a pallet along x and y (m); None leaves it to the recipe."""
    most_mass: float = np.inf
    """Greatest mass of pallet and goods (kg): a pallet's fraction of what the load notice allows its level."""
    in_line: bool = False
    """Whether the bay is a lane: slots in order from the aisle, reached through each other, filled from the far end."""


@dataclass(frozen=True, eq=False)
class Lane:
    """A strip of floor with places for stacks, one behind the other."""

    T_world_places: tuple[Transform, ...]
    """On the floor under each stack's centre, the aisle's end first; x away from the aisle, z up."""
    clear_height: float
    """Height that a stack may take (m)."""
    footprint: tuple[float, float]
    """Greatest edges of a pallet along the lane and across it (m)."""


@dataclass(frozen=True, eq=False)
class Strip:
    """A bare level surface on which things stand without a pallet: a shelf, decks on beams, a line of rollers."""

    T_world_strip: Transform
    """On the surface amid its front edge; x along it, y to its back, z up."""
    length: float
    """Free edge along x (m)."""
    depth: float
    """Free edge along y (m)."""
    headroom: float
    """Free height (m)."""
    fill: float = 0.0
    """Fraction of its length that goods of the recipe shall take, 0-1; 0 for what the layout has filled."""
    own_fraction: float = 1.0
    """Fraction of those that are the user's own, 0-1; the others are cartons."""
    one_kind: bool = True
    """Whether it holds one article."""


@dataclass(frozen=True, eq=False)
class Side:
    """What was built along one side of the aisle."""

    slots: Sequence[Slot] = ()
    lanes: Sequence[Lane] = ()
    backdrop: Sequence[Slot] = ()
    """Slots of racks behind the one along the aisle: seen and not reached, so that what stands there is fixed."""
    strips: Sequence[Strip] = ()
    """Bare surfaces, filled or to be filled."""
    side_aisles: Sequence[Area] = ()
    """Free floor between the racks behind (m, world)."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Site(Side):
    """What was built along both sides, and what is between and around them."""

    aisle: Area
    """Free floor: the rig drives and traffic moves on it, luminaires hang over it."""
    hall: Area
    """The floor between the inner faces of the hall's walls."""

    def places_of_loads(self) -> list[OrientedBox]:
        """Return the room of each load that may stand here."""
        rooms = [
            (slot.T_world_slot, slot.footprint or _FOOTPRINT, slot.headroom) for slot in (*self.slots, *self.backdrop)
        ]
        rooms += [(T, lane.footprint, lane.clear_height) for lane in self.lanes for T in lane.T_world_places]
        return [
            OrientedBox(
                T @ make_transform(translation=np.array([0.0, 0.0, height / 2])), np.array([*footprint, height])
            )
            for T, footprint, height in rooms
        ]


@dataclass(frozen=True)
@ranged
class Layout(ABC):
    """Where things stand: an aisle with something along its front, and a wall or more of it on the other side.

    In YAML: a mapping with ``kind`` and that kind's settings; without ``kind`` it is a rack aisle.
    """

    kind: ClassVar[str]
    kinds: ClassVar[dict[str, "type[Layout]"]] = {}
    """Value of ``layout.kind`` in a recipe -> its settings: every layout that is defined."""
    has_shelves: ClassVar[bool] = False
    """Whether some of its places can be kept for goods of the user's own, by the setting ``goods_fraction``."""

    aisle_width: Annotated[float, Range(1.5, 15, "m")] = 9.5
    """Free floor in front (m), 1.5-15; an observation needs its distance and about 1 m more, unless it looks along."""
    truck: Truck = "any"
    """What works in the aisle; a truck by name wants an aisle of its width (``AISLES``), any takes every width."""

    def __init_subclass__(cls) -> None:
        cls.kinds[cls.kind] = cls

    def __post_init__(self) -> None:
        low, high = AISLES[self.truck]
        if not low <= self.aisle_width <= high:
            raise ValueError(
                f"aisle_width must be {low}-{high} m for truck {self.truck}, found {self.aisle_width}; change either"
            )

    @property
    @abstractmethod
    def extent(self) -> tuple[float, float]:
        """How far it reaches along the aisle, and away from it (m)."""

    @property
    def length(self) -> float:
        """Extent along the aisle (m)."""
        return self.extent[0]

    @property
    def depth(self) -> float:
        """Extent away from the aisle (m)."""
        return self.extent[1]

    @property
    def gap(self) -> float:
        """Free space between what stands along the front and the wall behind it (m)."""
        return 0.4

    @property
    def door_modules(self) -> tuple[int, ...]:
        """Modules of the wall behind the front, 0-7 from its left end, that have a dock's opening."""
        return ()

    @property
    def sides(self) -> Literal["one", "both"]:
        """Whether the other side of the aisle is the same again; a setting of the layouts that can be."""
        return "one"

    @property
    def goods_fraction(self) -> float:
        """Fraction of its places kept for goods of the user's own, 0-1; a setting of layouts that have shelves."""
        return 0.0

    @property
    def opposite(self) -> "Layout | None":
        """What stands on the other side of the aisle: the same again where ``sides`` are both; None for a wall."""
        return self if self.sides == "both" else None

    @property
    def wants_goods(self) -> bool:
        """Whether it keeps room for goods of the user's own (``loads.goods``)."""
        return self.goods_fraction > 0.0

    def under(self, clear_height: float) -> "Layout":
        """Return the layout as it fits a hall of ``clear_height`` (m) over the floor; most fit as they are."""
        return self

    @abstractmethod
    def build_side(self, draft: SceneDraft, T_world_side: Transform, first_bay: int, rng: np.random.Generator) -> Side:
        """Add to ``draft`` what stands along the plane y = 0 of a side's own frame; the aisle is at negative y.

        Args:
            draft: Where to add it.
            T_world_side: The side's frame.
            first_bay: Number of the first bay.
            rng: Where tolerances come from.
        """

    @staticmethod
    def type_of(data: Any, where: str) -> "type[Layout]":
        """Return the class that a mapping's ``kind`` names.

        Raises:
            ConfigError: No layout has this kind.
        """
        kind = data.get("kind", "rack_aisle") if isinstance(data, dict) else "rack_aisle"
        if not isinstance(kind, str) or kind not in Layout.kinds:
            raise ConfigError(
                f"{where}: kind must be one of {', '.join(map(repr, sorted(Layout.kinds)))}, found {shown(kind)}"
                + suggestion(kind, Layout.kinds)
            )
        return Layout.kinds[kind]

    @classmethod
    def from_plain(cls, data: Any, where: str) -> Self:
        """Read a mapping with ``kind``.

        Raises:
            ConfigError: Unknown kind or wrong settings.
        """
        chosen = cls.type_of(data, where)
        settings = {key: value for key, value in data.items() if key != "kind"} if isinstance(data, dict) else data
        found = from_mapping(chosen, settings, where)
        if not isinstance(found, cls):
            raise ConfigError(f"{where}: kind must be {cls.kind!r}, found {chosen.kind!r}")
        return found

    def to_plain(self) -> dict[str, Any]:
        """Return what ``from_plain`` reads back."""
        settings = {field.name: to_mapping(getattr(self, field.name)) for field in fields(self)}
        return {"kind": self.kind, **settings}


def aisle_area(layout: Layout) -> Area:
    """Return the free floor between both sides (m)."""
    half = max(layout.length, layout.opposite.length if layout.opposite else 0.0) / 2
    return Area(-half, half, -layout.aisle_width, 0.0)


def build_site(draft: SceneDraft, layout: Layout, hall: HallConfig, rng: np.random.Generator) -> Site:
    """Add the hall and both sides of the aisle to ``draft``."""
    layout = layout.under(hall.free_height)
    other = layout.opposite
    y_front = layout.depth + _wall_gap(layout, hall)
    y_back = -layout.aisle_width - other.depth - _wall_gap(other, hall) if other else None
    aisle = aisle_area(layout)
    if not hall.is_sized:
        _require_floor(y_front, y_back, aisle)
    walls = build_hall(
        draft,
        hall,
        y_front,
        y_back,
        layout.door_modules,
        y_least=aisle.y_min,
        length_needed=aisle.x_max - aisle.x_min,
    )
    sides = [layout.build_side(draft, np.eye(4), 0, rng)]
    if other is not None:
        T_world_side = make_transform(HALF_TURN, np.array([0.0, -layout.aisle_width, 0.0]))
        sides.append(other.build_side(draft, T_world_side, len(sides[0].slots), rng))
    add_tyre_marks(draft, hall.tyre_marks, aisle, rng)
    built = {item.name: tuple(chain(*(getattr(side, item.name) for side in sides))) for item in fields(Side)}
    return Site(aisle=aisle, hall=walls, **built)


def _require_floor(y_front: float, y_back: float | None, aisle: Area) -> None:
    """Reject what is larger than the slab.

    Raises:
        PlacementError: It is.
    """
    half = FLOOR_SIZE[1] / 2 - WALL_SIZE[1]
    needed = max(y_front, -(aisle.y_min if y_back is None else y_back))
    if needed > half or aisle.x_max > FLOOR_SIZE[0] / 2 - WALL_SIZE[1]:
        raise PlacementError(
            f"the layout reaches {needed:.1f} m across and {aisle.x_max:.1f} m along from the middle, the hall "
            f"{half:.1f} m; lower layout.rows_behind, layout.bays or layout.aisle_width"
        )


def _wall_gap(layout: Layout, hall: HallConfig) -> float:
    """Return the free space behind a side (m), enough for columns where there are any."""
    return max(layout.gap, _COLUMN_GAP) if hall.columns != "none" and not layout.door_modules else layout.gap
