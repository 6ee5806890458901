"""Settings of what hangs under the roof, on walls and stands beside ways; all of it is left out by default."""

from dataclasses import dataclass
from typing import Annotated

from warehouse_sim.ranges import Range, ranged


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
