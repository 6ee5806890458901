"""Where services hang (pipes, trays, ducts, rows of light, rooflights, high windows), and what a recipe says of it."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated

import numpy as np

from warehouse_sim.catalog.building import to_size as parts
from warehouse_sim.geometry.pose import make_transform, rotation_z
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.scene.draft import Area, SceneDraft
from warehouse_sim.schema import ObjectModel


@dataclass(frozen=True)
@ranged
class ServicesConfig:
    """What a hall is equipped with. What hangs under the roof needs ``hall.roof``."""

    sprinklers: bool = False
    """Red pipes across the hall with a sprinkler head every 3 m."""
    cable_trays: bool = False
    """Galvanised trays with cables along the hall, below the girders."""
    ducts: bool = False
    """Ventilation ducts along the hall's long walls, below the girders."""
    light_lines: bool = False
    """Rows of trunking luminaires over all of the hall that the aisle's own luminaires leave free."""
    rooflights: bool = False
    """Strips of rooflight between the girders, which show the day, dusk or night of the light's preset."""
    windows: bool = False
    """Bands of windows high in the walls, which show the same."""
    signs: bool = False
    """Exit signs over the doors, signs on the walls, numbers over the aisle's ends, load notices."""
    fire_equipment: bool = False
    """Extinguishers with their signs and hose cabinets on walls and columns."""
    guards: bool = False
    """Collars around columns, rails along the wall, bumpers beside dock doors."""
    markings: bool = False
    """Keep-clear fields before doors, a crossing, corner markings beside the aisle, lines along the walls."""
    floor_labels: bool = False
    """Labels with a barcode on the floor beside the aisle."""
    bins: Annotated[int, Range(0, 8)] = 0
    """Rubbish bins along the walls, 0-8."""
    floor_signs: Annotated[int, Range(0, 4)] = 0
    """Folding signs that warn of a wet floor, at the aisle's sides, 0-4."""


_PIPE_PITCH = 3.5
"""Greatest distance between sprinkler pipes (m); 3-4 at ordinary hazards (EN 12845)."""
_LINE_PITCH = 6.0
"""Distance between rows of light (m)."""
_BESIDE_AISLE = 2.0
"""Distance that rows of light keep from the floor that has luminaires of its own (m)."""
_LOAD_ON_TOP = 1.9
"""What a load on the highest beams may reach above them (m)."""
_FROM_WALL = 0.9
_WINDOW = (1.2, 0.9)  # height of a band of windows, and how far its upper edge stays below the girders (m)


@dataclass(frozen=True)
class Roof:
    """What is known of the space under the roof."""

    floor: Area
    """Between the walls."""
    height: float
    """Of the roof above the floor (m)."""
    under_girders: float
    """Height of the girders' underside, or of the roof where there are none (m)."""
    girders: tuple[float, ...]
    """Their places along x (m)."""


def roof_over(draft: SceneDraft, floor: Area, height: float) -> Roof:
    """Return what the girders of a draft leave free."""
    found = [item for item in draft.instances if item.model.startswith(("roof_truss", "roof_beam"))]
    lowest = [item.T_world_object[2, 3] - draft.models[item.model].size[2] / 2 for item in found]
    places = tuple(sorted(float(item.T_world_object[0, 3]) for item in found))
    return Roof(floor, height, float(min(lowest, default=height)), places)


def hang_services(draft: SceneDraft, config: ServicesConfig, roof: Roof, aisle: Area) -> None:
    """Hang what ``config`` requires."""
    tops = _tops(draft)
    if config.sprinklers:
        _hang_sprinklers(draft, roof)
    along, middle = roof.floor.x_max - roof.floor.x_min - 0.4, (roof.floor.x_min + roof.floor.x_max) / 2

    def run(model: ObjectModel, y: float, drop: float = 0.0) -> None:
        """Hang something along x below the girders, unless what stands there reaches that high."""
        z = roof.under_girders - drop - model.size[2] / 2
        if _reach(tops, y, model.size[1] / 2) < z - model.size[2] / 2:
            draft.put(model, (middle, y, z))

    if config.cable_trays:
        run(parts.cable_tray(along), roof.floor.y_max - _FROM_WALL)
        run(parts.cable_tray(along), aisle.y_min - 0.6)
    if config.ducts:
        for y in (roof.floor.y_min + 1.6, roof.floor.y_max - 2.0):
            run(parts.duct(along), y)
    if config.light_lines:
        for y in _rows(roof.floor, aisle):
            run(parts.light_line(round(along - 1.0, 3)), y)
    if config.rooflights:
        _lay_rooflights(draft, roof)
    if config.windows:
        _set_windows(draft, roof, tops)


def _hang_sprinklers(draft: SceneDraft, roof: Roof) -> None:
    """Hang pipes across the hall between its girders, and the main that feeds them below the girders."""
    floor, width = roof.floor, roof.floor.y_max - roof.floor.y_min
    pipe = parts.sprinkler_line(round(width - 0.6, 3))
    count = int(np.ceil((floor.x_max - floor.x_min) / _PIPE_PITCH))
    for x in floor.x_min + (np.arange(count) + 0.5) * (floor.x_max - floor.x_min) / count:
        near = [girder for girder in roof.girders if abs(girder - x) < 0.25]
        at = x if not near else near[0] + np.copysign(0.25, x - near[0])
        # Below purlins, which stand 0.1 m into the hall from where the roof begins.
        z = roof.height - 0.25 - pipe.size[2] / 2
        pose = make_transform(rotation_z(np.pi / 2), np.array([at, (floor.y_min + floor.y_max) / 2, z]))
        draft.add(pipe, pose)


def _lay_rooflights(draft: SceneDraft, roof: Roof) -> None:
    """Lay strips of rooflight along x between the girders, in rows about 8 m apart."""
    floor = roof.floor
    edges = [floor.x_min, *roof.girders, floor.x_max]
    rows = max(int((floor.y_max - floor.y_min) / 8.0), 1)
    for left, right in pairwise(edges):
        length = min(right - left - 1.2, 6.0)
        if length < 1.5:
            continue
        model = parts.rooflight(round(length, 2))
        for row in range(rows):
            y = floor.y_min + (row + 0.5) * (floor.y_max - floor.y_min) / rows
            draft.put(model, ((left + right) / 2, y, roof.height - model.size[2] / 2 - 0.002))


def _set_windows(draft: SceneDraft, roof: Roof, tops: np.ndarray) -> None:
    """Set bands of windows high in the walls, before their inner faces."""
    floor, (tall, drop) = roof.floor, _WINDOW
    z = roof.under_girders - drop - tall / 2
    if z - tall / 2 < 2.6:
        return
    for turn, wall, low, high in (
        (0.0, floor.y_max, floor.x_min, floor.x_max),
        (np.pi, floor.y_min, floor.x_min, floor.x_max),
        (np.pi / 2, floor.x_min, floor.y_min, floor.y_max),
        (-np.pi / 2, floor.x_max, floor.y_min, floor.y_max),
    ):
        count = int((high - low) / 9.0)
        model = parts.window_band(6.0, tall)
        for place in low + (np.arange(count) + 0.5) * (high - low) / max(count, 1):
            inward = model.size[1] / 2 + 0.002
            across = wall + (inward if turn in (np.pi, np.pi / 2) else -inward)
            at = [place, across, z] if turn in (0.0, np.pi) else [across, place, z]
            draft.add(model, make_transform(rotation_z(turn), np.array(at)))


def _rows(floor: Area, aisle: Area) -> list[float]:
    """Return where rows of light hang across the hall, beside the aisle."""
    count = max(int((floor.y_max - floor.y_min) / _LINE_PITCH), 1)
    rows = floor.y_min + (np.arange(count) + 0.5) * (floor.y_max - floor.y_min) / count
    low, high = aisle.y_min - _BESIDE_AISLE, aisle.y_max + _BESIDE_AISLE
    return [float(y) for y in rows if y < low or y > high]


def _tops(draft: SceneDraft) -> np.ndarray:
    """Return least y, greatest y and top (m) of all that stands in the hall, the shell left out."""
    solids = draft.solids()
    shell = [item.instance_id for item in draft.instances if draft.models[item.model].class_name in _SHELL]
    low, high = solids.extents
    chosen = ~solids.of_objects(shell)
    return np.column_stack([low[chosen, 1], high[chosen, 1], high[chosen, 2]])


_SHELL = ("floor", "wall", "ceiling", "column", "luminaire", "marking", "door", "trailer", "dock", "outdoors")


def _reach(tops: np.ndarray, y: float, half: float) -> float:
    """Return how high what stands across ``y`` reaches with its loads (m)."""
    near = tops[(tops[:, 0] < y + half + 0.3) & (tops[:, 1] > y - half - 0.3), 2]
    return float(near.max(initial=0.0)) + (_LOAD_ON_TOP if near.size else 0.0)
