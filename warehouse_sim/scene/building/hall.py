"""The hall around an aisle: slab, four walls, roof and columns, and what years of traffic leave on the floor."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated, Literal

import numpy as np

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.building.dock import SEAL_SIZE, dock_sill
from warehouse_sim.catalog.building.outdoors import RISE, outdoors
from warehouse_sim.catalog.building.shell import FLOOR_SIZE, MODULE_LENGTH, OPENING_HEIGHT, OPENING_WIDTH, WALL_SIZE
from warehouse_sim.catalog.building.structure import CEILING_SIZE, TRUSS_SIZE
from warehouse_sim.catalog.building.to_size import (
    WALL_THICKNESS,
    FloorKind,
    RoofKind,
    WallKind,
    column_to_size,
    girder_depth,
    girder_to_size,
    roof_to_size,
    slab_to_size,
    wall_to_size,
)
from warehouse_sim.errors import PlacementError
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import rotation_z
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.scene.building.floor import wear_floor
from warehouse_sim.scene.building.furnishing import furnish
from warehouse_sim.scene.building.services import ServicesConfig, hang_services, roof_over
from warehouse_sim.scene.draft import QUARTER_TURN, Area, SceneDraft
from warehouse_sim.schema import ObjectModel

_BAY = 12.0
"""Greatest distance between girders and between columns (m); 5-12 are usual, with purlins between them."""
_AISLE_END = 0.3
"""Least free floor between what stands in the hall and the walls at the aisle's ends (m)."""
_SILL = 0.01
"""Depth of the middle of a dock's sill below the floor (m)."""
_COLLAR = 0.07
"""Between columns and the wall (m), where their guards go round."""
_SPACE_BEHIND = 12.0
"""Width that a hall of no given width adds behind an aisle with one side (m)."""


_FLOORS = {"concrete": "floor_slab", "jointed": "floor_slab_jointed", "epoxy": "floor_slab_epoxy"}
_WALLS = {"panels": "wall", "cladding": "wall_clad"}
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

    Raises:
        PlacementError: The hall is smaller than what it has to hold.
    """
    if config.is_sized:
        needs = Area(-length_needed / 2, length_needed / 2, y_least if y_back is None else y_back, y_front)
        floor = _build_to_size(
            draft, config, needs, [module_x(index) for index in doors], y_back is None or bool(doors)
        )
    else:
        floor = _build_fixed(draft, config, y_front, y_back, doors)
    if config.outdoors:
        length, width = floor.x_max - floor.x_min, floor.y_max - floor.y_min
        middle = ((floor.x_min + floor.x_max) / 2, (floor.y_min + floor.y_max) / 2, RISE)
        draft.put(outdoors("outdoors", round(length, 3), round(width, 3)), middle)
    return floor


def _build_to_size(
    draft: SceneDraft, config: HallConfig, needs: Area, doors: Sequence[float], keeps_front: bool
) -> Area:
    """Add the shell of a hall of any size around what it ``needs`` to hold (m), with docks at x = ``doors`` (m).

    What the hall is wider stays free behind the aisle where it ``keeps_front``, else beyond both of its sides.
    """
    floor = _floor_of(config, needs, keeps_front)
    length, width = floor.x_max - floor.x_min, floor.y_max - floor.y_min
    x, y, height = (floor.x_min + floor.x_max) / 2, (floor.y_min + floor.y_max) / 2, config.clear_height
    outer = (length + 2 * WALL_THICKNESS, width + 2 * WALL_THICKNESS)

    def put(model: ObjectModel, at: tuple[float, float, float], turn: float = 0.0) -> None:
        draft.put(model, at, rotation=rotation_z(turn))

    put(slab_to_size(config.floor, *outer), (x, y, -FLOOR_SIZE[2] / 2))
    openings = tuple((at - x, OPENING_WIDTH, OPENING_HEIGHT) for at in sorted(doors))
    up, off = height / 2, WALL_THICKNESS / 2
    put(wall_to_size(config.walls, outer[0], height, openings), (x, floor.y_max + off, up))
    for at in doors:
        put(dock_sill(), (at, floor.y_max + WALL_THICKNESS + SEAL_SIZE[1] / 2, -_SILL))
    put(wall_to_size(config.walls, outer[0], height), (x, floor.y_min - off, up), np.pi)
    side = wall_to_size(config.walls, width, height)
    put(side, (floor.x_min - off, y, up), np.pi / 2)
    put(side, (floor.x_max + off, y, up), -np.pi / 2)
    bays = max(int(np.ceil(length / _BAY - 1e-6)), 1)
    places = [float(floor.x_min + (number + 0.5) * length / bays) for number in range(bays)]
    if config.roof:
        put(roof_to_size(config.roof_kind, *outer), (x, y, height + CEILING_SIZE[2] / 2))
        depth = girder_depth(config.roof_kind, width)
        for at in places if depth else ():
            put(girder_to_size(config.roof_kind, width), (at, y, height - depth / 2), np.pi / 2)
    if config.columns != "none":
        column = column_to_size(config.columns, height)
        off_wall = column.size[1] / 2 + _COLLAR
        for wall_y in (floor.y_max - off_wall, floor.y_min + off_wall):
            for at in places:
                if all(abs(at - door) > OPENING_WIDTH / 2 + 0.5 for door in doors) or wall_y < y:
                    put(column, (at, float(wall_y), up))
    return floor


def _floor_of(config: HallConfig, needs: Area, keeps_front: bool) -> Area:
    """Return the floor of the hall around what it has to hold (m)."""
    length = FLOOR_SIZE[0] - 2 * WALL_SIZE[1] if config.length is None else config.length
    depth = needs.y_max - needs.y_min
    width = (depth + (_SPACE_BEHIND if keeps_front else 0.0)) if config.width is None else config.width
    for key, has, wants, remedy in (
        ("length", length, needs.x_max - needs.x_min + 2 * _AISLE_END, "layout's bays, lanes or doors"),
        ("width", width, depth, "layout's depth or aisle_width"),
    ):
        if has < wants - 1e-6:
            raise PlacementError(
                f"hall.{key}: a clear {has:.2f} m does not hold the {wants:.2f} m that stands in it; "
                f"raise hall.{key} or lower the {remedy}"
            )
    rest = width - depth
    front = 0.0 if keeps_front else rest / 2
    return Area(-length / 2, length / 2, needs.y_min - rest + front, needs.y_max + front)


def _build_fixed(
    draft: SceneDraft, config: HallConfig, y_front: float, y_back: float | None, doors: Sequence[int]
) -> Area:
    """Add the hall of 48 x 48 x 9 m."""
    draft.put(_FLOORS[config.floor], (0.0, 0.0, -FLOOR_SIZE[2] / 2))
    thick, middle = WALL_SIZE[1] / 2, WALL_SIZE[2] / 2
    end = (FLOOR_SIZE[1] - WALL_SIZE[1]) / 2
    back = -end if y_back is None else max(-end, y_back - thick)
    side = (FLOOR_SIZE[0] - WALL_SIZE[1]) / 2
    walls = [(0.0, back, None), (-side, 0.0, QUARTER_TURN), (side, 0.0, QUARTER_TURN)]
    if doors:
        for index in range(round(WALL_SIZE[0] / MODULE_LENGTH)):
            name = "wall_module_dock" if index in doors else "wall_module"
            draft.put(name, (module_x(index), y_front + thick, middle))
    else:
        walls.insert(0, (0.0, y_front + thick, None))
    for x, y, rotation in walls:
        wall = _WALLS.get(config.walls) or wall_to_size(config.walls, WALL_SIZE[0], WALL_SIZE[2])
        draft.put(wall, (x, y, middle), rotation=rotation)
    places = np.arange(-1.5, 2.0) * _COLUMN_PITCH
    if config.roof:
        draft.put("ceiling", (0.0, 0.0, WALL_SIZE[2] + CEILING_SIZE[2] / 2))
        for x in places:
            draft.put("roof_truss", (x, 0.0, WALL_SIZE[2] - TRUSS_SIZE[2] / 2), rotation=QUARTER_TURN)
    if config.columns != "none":
        column = catalog_object(f"column_{config.columns}")
        _, depth, height = column.size
        for y in [y_front - depth / 2] + ([] if y_back is None else [back + thick + depth / 2]):
            for x in places:
                draft.put(column, (x, y, height / 2))
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
