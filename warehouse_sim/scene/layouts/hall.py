"""The hall around an aisle: slab, four walls, roof and columns, and what years of traffic leave on the floor."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated, Literal

import numpy as np

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.building.floor_marks import PAINT
from warehouse_sim.catalog.building.outdoors import RISE, outdoors
from warehouse_sim.catalog.building.shell import FLOOR_SIZE, MODULE_LENGTH, WALL_SIZE
from warehouse_sim.catalog.building.structure import CEILING_SIZE, TRUSS_SIZE
from warehouse_sim.catalog.building.to_size import FloorKind, RoofKind, WallKind, girder_depth, wall_to_size
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.scene.building.floor import wear_floor
from warehouse_sim.scene.building.furnishing import furnish
from warehouse_sim.scene.building.services import ServicesConfig, hang_services, roof_over
from warehouse_sim.scene.building.sized_hall import SizedHall, build_to_size
from warehouse_sim.scene.draft import QUARTER_TURN, Area, SceneDraft

_FLOORS = {"concrete": "floor_slab", "jointed": "floor_slab_jointed", "epoxy": "floor_slab_epoxy"}
_WALLS = {"panels": "wall", "cladding": "wall_clad"}
_, _CURVE = _TYRE_MARKS = ("tyre_mark_straight", "tyre_mark_curve")
"""Straight ones lie along the aisle, bends any way."""
_LINE_LENGTHS = (6.0, 3.0, 1.0)
_WIDEST = 40.0
"""Width (m) that a hall of no given width is taken to have where girders' depth is requested."""
_COLUMN_PITCH = 12.0
"""Distance between columns and between trusses (m); 10-24 m are usual in halls."""


@dataclass(frozen=True)
@ranged
class HallConfig:
    """What the hall is made of, how large it is, and what hangs, stands and lies in it.

    Without ``length``, ``width`` and ``height`` it is 48 x 48 x 9 m. With one of them it is built to size.
    """

    floor: FloorKind = "concrete"
    """Plain slab, slab with sawn joints, or joints under a coat of epoxy: concrete, jointed or epoxy."""
    walls: WallKind = "panels"
    """Painted panels, trapezoidal sheet (cladding), sandwich (white, of cold stores), blockwork or plaster."""
    roof: bool = False
    """Whether there is a roof; without one the hall is open above."""
    roof_kind: RoofKind = "truss"
    """What carries it: trusses or beams; board is a suspended ceiling, as in shops."""
    columns: Literal["none", "steel", "concrete"] = "none"
    """Columns in rows of 12 m along both sides, behind what stands there and, with guards, beside the aisle's ends."""
    length: Annotated[float, Range(10, 120, "m")] | None = None
    """Inner length along the aisle (m), 10-120; null for 48 m less its walls."""
    width: Annotated[float, Range(10, 120, "m")] | None = None
    """Inner width across the aisle (m), 10-120; null for what the layout needs."""
    height: Annotated[float, Range(3, 14, "m")] | None = None
    """Clear height from the floor to the roof (m), 3-14; girders hang below it. Null for 9 m."""
    outdoors: bool = False
    """Whether there is a yard with a sky over it around the hall, to be seen through its openings."""
    tyre_marks: Annotated[int, Range(0, 20)] = 0
    """Tyre marks of single manoeuvres on the floor of the aisle, 0-20."""
    tyre_tracks: Annotated[int, Range(0, 30)] = 0
    """Faint tracks that passing trucks left along the aisle, 0-30."""
    stains: Annotated[int, Range(0, 60)] = 0
    """Oil stains on the floor of the aisle, 0-60."""
    patches: Annotated[int, Range(0, 20)] = 0
    """Repaired patches in the floor of the aisle, 0-20."""
    puddles: Annotated[int, Range(0, 10)] = 0
    """Puddles on the floor of the aisle, 0-10."""
    services: ServicesConfig = field(default_factory=ServicesConfig)
    """What hangs under the roof, on walls and stands beside ways."""

    @property
    def is_sized(self) -> bool:
        """Whether the hall is built to a size of its own."""
        return not (self.length is None and self.width is None and self.height is None)

    @property
    def clear_height(self) -> float:
        """From the floor to the roof (m)."""
        return WALL_SIZE[2] if self.height is None else self.height

    @property
    def free_height(self) -> float:
        """From the floor to the lowest that carries the roof (m); girders of a hall of no given width may be deep."""
        if not self.roof:
            return self.clear_height
        if not self.is_sized:
            return self.clear_height - TRUSS_SIZE[2]
        return self.clear_height - girder_depth(self.roof_kind, _WIDEST if self.width is None else self.width)


def build_hall(
    draft: SceneDraft,
    config: HallConfig,
    y_front: float,
    y_back: float | None,
    doors: Sequence[int],
    *,
    y_least: float = -10.0,
    length_needed: float = 0.0,
    height_needed: float = 0.0,
) -> Area:
    """Add the shell; return the floor between the inner faces of its walls.

    Args:
        draft: Where to add it.
        config: What it is made of.
        y_front: Where the inner face of the wall behind the front side is, at least (m).
        y_back: Where the inner face of the wall opposite is, at most (m); None for the hall's end.
        doors: Modules of the front wall that have a dock's opening, 0-7 from the left end of a wall of 48 m.
        y_least: Where the free floor of the aisle ends that has nothing on its other side (m).
        length_needed: What stands in it takes along the aisle, even about x = 0 (m).
        height_needed: What stands in it takes from the floor up (m).

    Raises:
        PlacementError: The hall is smaller than what it has to hold.
    """
    if config.is_sized:
        needs = Area(-length_needed / 2, length_needed / 2, y_least if y_back is None else y_back, y_front)
        at = [module_x(index) for index in doors]
        floor = build_to_size(draft, _sized(config), needs, at, height_needed, y_back is None)
    else:
        floor = _build_fixed(draft, config, y_front, y_back, doors)
    if config.outdoors:
        middle = np.array([(floor.x_min + floor.x_max) / 2, (floor.y_min + floor.y_max) / 2, RISE])
        length, width = floor.x_max - floor.x_min, floor.y_max - floor.y_min
        draft.add(outdoors("outdoors", round(length, 3), round(width, 3)), make_transform(translation=middle))
    return floor


def _sized(config: HallConfig) -> SizedHall:
    wall = 2 * WALL_SIZE[1]
    length = FLOOR_SIZE[0] - wall if config.length is None else config.length
    columns = None if config.columns == "none" else config.columns
    return SizedHall(
        config.floor, config.walls, config.roof_kind if config.roof else None, columns, length, config.width,
        config.clear_height,
    )  # fmt: skip


def _build_fixed(
    draft: SceneDraft, config: HallConfig, y_front: float, y_back: float | None, doors: Sequence[int]
) -> Area:
    """Add the hall of 48 x 48 x 9 m."""
    draft.add(_FLOORS[config.floor], make_transform(translation=np.array([0.0, 0.0, -FLOOR_SIZE[2] / 2])))
    thick, middle = WALL_SIZE[1] / 2, WALL_SIZE[2] / 2
    end = (FLOOR_SIZE[1] - WALL_SIZE[1]) / 2
    back = -end if y_back is None else max(-end, y_back - thick)
    side = (FLOOR_SIZE[0] - WALL_SIZE[1]) / 2
    walls = [(0.0, back, None), (-side, 0.0, QUARTER_TURN), (side, 0.0, QUARTER_TURN)]
    if doors:
        for index in range(round(WALL_SIZE[0] / MODULE_LENGTH)):
            name = "wall_module_dock" if index in doors else "wall_module"
            draft.add(name, make_transform(translation=np.array([module_x(index), y_front + thick, middle])))
    else:
        walls.insert(0, (0.0, y_front + thick, None))
    for x, y, rotation in walls:
        wall = _WALLS.get(config.walls) or wall_to_size(config.walls, WALL_SIZE[0], WALL_SIZE[2])
        draft.add(wall, make_transform(rotation, np.array([x, y, middle])))
    if config.roof:
        _add_roof(draft)
    if config.columns != "none":
        _add_columns(draft, f"column_{config.columns}", y_front, None if y_back is None else back + thick)
    return Area(thick - side, side - thick, back + thick, y_front)


def equip_hall(
    draft: SceneDraft,
    config: HallConfig,
    aisle: Area,
    floor: Area,
    rng: np.random.Generator,
    kept: Sequence[OrientedBox] = (),
) -> None:
    """Add what hangs, stands and lies in a hall whose shell and sides are built and whose luminaires hang.

    Args:
        draft: Where to add it.
        config: What to add.
        aisle: Free floor between the sides.
        floor: Between the hall's walls.
        rng: Where places come from.
        kept: Places of loads that are still to come.
    """
    if config.services != ServicesConfig():
        roof = roof_over(draft, floor, config.clear_height)
        if config.roof:
            hang_services(draft, config.services, roof, aisle)
        furnish(draft, config.services, roof, aisle, rng, kept)
    counts = {"tracks": config.tyre_tracks, "stain": config.stains, "patch": config.patches, "water": config.puddles}
    wear_floor(draft, counts, aisle, rng)


def module_x(index: int) -> float:
    """Return x of the middle of a wall module (m)."""
    return (index + 0.5) * MODULE_LENGTH - WALL_SIZE[0] / 2


def add_tyre_marks(draft: SceneDraft, count: int, area: Area, rng: np.random.Generator) -> None:
    """Leave tyre marks on the floor of ``area``."""
    for _ in range(count):
        name = str(rng.choice(_TYRE_MARKS))
        x, y = rng.uniform(area.x_min, area.x_max), rng.uniform(area.y_min, area.y_max)
        yaw = rng.uniform(-np.pi, np.pi) if name == _CURVE else rng.normal(0.0, 0.15)
        # Each a little higher than the one before, so that crossing marks do not share a plane.
        z = catalog_object(name).size[2] / 2 + 0.0001 * (1 + rng.random())
        draft.add(name, make_transform(rotation_z(yaw), np.array([x, y, z])))


def mark_line(
    draft: SceneDraft, T_world_side: Transform, start: Sequence[float], length: float, along: str, colour: str
) -> None:
    """Paint a line from ``start`` (x, y in a side's frame, m) in the direction of its "x" or "y" axis.

    Lines come in lengths of 6, 3 and 1 m; what is left at the end stays bare.
    """
    direction = np.array([1.0, 0.0, 0.0]) if along == "x" else np.array([0.0, 1.0, 0.0])
    rotation = None if along == "x" else QUARTER_TURN
    at, rest = np.array([start[0], start[1], PAINT / 2]), length
    for piece in _LINE_LENGTHS:
        while rest >= piece - 1e-6:
            T_side_line = make_transform(rotation, at + direction * piece / 2)
            draft.add(f"lane_line_{colour}_{round(1000 * piece)}", T_world_side @ T_side_line)
            at, rest = at + direction * piece, rest - piece


def _add_roof(draft: SceneDraft) -> None:
    under = WALL_SIZE[2]
    draft.add("ceiling", make_transform(translation=np.array([0.0, 0.0, under + CEILING_SIZE[2] / 2])))
    for x in np.arange(-1.5, 2.0) * _COLUMN_PITCH:
        at = np.array([x, 0.0, under - TRUSS_SIZE[2] / 2])
        draft.add("roof_truss", make_transform(QUARTER_TURN, at))


def _add_columns(draft: SceneDraft, name: str, y_front: float, y_back: float | None) -> None:
    """Add a row of columns along the inner face of the front wall, and one along the wall opposite."""
    size = catalog_object(name).size
    rows = [y_front - size[1] / 2] + ([] if y_back is None else [y_back + size[1] / 2])
    for y in rows:
        for x in np.arange(-1.5, 2.0) * _COLUMN_PITCH:
            draft.add(name, make_transform(translation=np.array([x, y, size[2] / 2])))
