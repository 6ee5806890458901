"""The shell of a hall of any size around what a layout needs."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from warehouse_sim.catalog.building.dock import SEAL_SIZE, dock_sill
from warehouse_sim.catalog.building.shell import FLOOR_SIZE, OPENING_HEIGHT, OPENING_WIDTH
from warehouse_sim.catalog.building.structure import CEILING_SIZE
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
from warehouse_sim.geometry.pose import make_transform, rotation_z
from warehouse_sim.scene.draft import Area, SceneDraft
from warehouse_sim.schema import ObjectModel

BAY = 12.0
"""Greatest distance between girders and between columns (m); 5-12 are usual, with purlins between them."""
_AISLE_END = 0.3
"""Least free floor between what stands in the hall and the walls at the aisle's ends (m)."""
_SILL = 0.01
"""Depth of the middle of a dock's sill below the floor (m)."""
_COLLAR = 0.07
"""Between columns and the wall (m), where their guards go round."""
_SPACE_BEHIND = 12.0
"""Width that a hall of no given width adds behind an aisle with one side (m)."""


@dataclass(frozen=True)
class SizedHall:
    """What the hall is made of and its inner size."""

    floor: FloorKind
    walls: WallKind
    roof: RoofKind | None
    columns: Literal["steel", "concrete"] | None
    length: float
    """Along x (m)."""
    width: float | None
    """Along y (m); None for what is needed."""
    height: float
    """From the floor to the roof (m)."""


def build_to_size(
    draft: SceneDraft,
    hall: SizedHall,
    needs: Area,
    doors: Sequence[float],
    height_needed: float = 0.0,
    one_sided: bool = False,
) -> Area:
    """Add the shell; return the floor between its walls.

    Args:
        draft: Where to add it.
        hall: What to build.
        needs: What the hall has to hold (m): its greatest y is the inner face of the front wall where that has doors.
            What the hall is wider stays free: behind the aisle, or beyond both of its sides.
        doors: Middles along x of the dock doors in the front wall (m).
        height_needed: How high things in it reach (m).
        one_sided: Whether nothing stands beyond the aisle's back.

    Raises:
        PlacementError: The hall is smaller than what it has to hold.
    """
    floor = _floor_of(hall, needs, one_sided or bool(doors), height_needed)
    length, width = floor.x_max - floor.x_min, floor.y_max - floor.y_min
    x, y, height = (floor.x_min + floor.x_max) / 2, (floor.y_min + floor.y_max) / 2, hall.height
    outer = (length + 2 * WALL_THICKNESS, width + 2 * WALL_THICKNESS)

    def put(model: ObjectModel, at: tuple[float, float, float], turn: float = 0.0) -> None:
        draft.add(model, make_transform(rotation_z(turn), np.array(at)))

    put(slab_to_size(hall.floor, *outer), (x, y, -FLOOR_SIZE[2] / 2))
    openings = tuple((at - x, OPENING_WIDTH, OPENING_HEIGHT) for at in sorted(doors))
    up, off = height / 2, WALL_THICKNESS / 2
    put(wall_to_size(hall.walls, outer[0], height, openings), (x, floor.y_max + off, up))
    for at in doors:
        put(dock_sill(), (at, floor.y_max + WALL_THICKNESS + SEAL_SIZE[1] / 2, -_SILL))
    put(wall_to_size(hall.walls, outer[0], height), (x, floor.y_min - off, up), np.pi)
    side = wall_to_size(hall.walls, width, height)
    put(side, (floor.x_min - off, y, up), np.pi / 2)
    put(side, (floor.x_max + off, y, up), -np.pi / 2)
    places = evenly(floor.x_min, floor.x_max, BAY)
    if hall.roof is not None:
        put(roof_to_size(hall.roof, *outer), (x, y, height + CEILING_SIZE[2] / 2))
        depth = girder_depth(hall.roof, width)
        for at in places if depth else ():
            put(girder_to_size(hall.roof, width), (at, y, height - depth / 2), np.pi / 2)
    if hall.columns is not None:
        column = column_to_size(hall.columns, height)
        off_wall = column.size[1] / 2 + _COLLAR
        for wall_y in (floor.y_max - off_wall, floor.y_min + off_wall):
            for at in places:
                if all(abs(at - door) > OPENING_WIDTH / 2 + 0.5 for door in doors) or wall_y < y:
                    put(column, (at, float(wall_y), up))
    return floor


def evenly(low: float, high: float, greatest: float) -> list[float]:
    """Return the middles of equal bays of at most ``greatest`` m between ``low`` and ``high``."""
    count = max(int(np.ceil((high - low) / greatest - 1e-6)), 1)
    return [float(low + (number + 0.5) * (high - low) / count) for number in range(count)]


def _floor_of(hall: SizedHall, needs: Area, keeps_front: bool, height_needed: float) -> Area:
    """Return the floor of the hall around what it has to hold (m)."""
    needed = needs.x_max - needs.x_min + 2 * _AISLE_END
    depth = needs.y_max - needs.y_min
    width = (depth + (_SPACE_BEHIND if keeps_front else 0.0)) if hall.width is None else hall.width
    free = hall.height - girder_depth(hall.roof or "board", width)
    for key, has, wants, remedy in (
        ("length", hall.length, needed, "layout's bays, lanes or doors"),
        ("width", width, depth, "layout's depth or aisle_width"),
        ("height", free, height_needed, "layout's highest level (girders hang below the roof)"),
    ):
        if has < wants - 1e-6:
            raise PlacementError(
                f"hall.{key}: a clear {has:.2f} m does not hold the {wants:.2f} m that stands in it; "
                f"raise hall.{key} or lower the {remedy}"
            )
    rest = width - depth
    front = 0.0 if keeps_front else rest / 2
    return Area(-hall.length / 2, hall.length / 2, needs.y_min - rest + front, needs.y_max + front)
