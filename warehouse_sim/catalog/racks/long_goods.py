"""Long goods for cantilever racks: bundles of pipes and hollow sections, packs of boards and of sheets.

Frame of all: x along the goods, z up, origin at the centre of the bounding box. Lengths are those of the trade: tubes
6 m, construction timber 4 m and 5 m, panels 2.5 x 1.25 m.
"""

import numpy as np

from warehouse_sim.catalog.parts import box_part, fused, model_of, solid_part
from warehouse_sim.geometry.solids import unit_tube
from warehouse_sim.schema import ObjectModel, Part

_ALONG_X = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


def pipe_bundle(name: str = "pipe_bundle") -> ObjectModel:
    """Build 22 steel pipes of 60.3 mm (DN 50) in four rows, every other one shifted by half."""
    return _pipes(name, 524, 0.0603, 6, 4, "galvanised", 670.0)


def plastic_pipe_bundle(name: str = "plastic_pipe_bundle") -> ObjectModel:
    """Build 8 sewer pipes of 110 mm (DN 110) in three rows."""
    return _pipes(name, 525, 0.11, 3, 3, "cone_orange", 75.0)


def section_bundle(name: str = "section_bundle") -> ObjectModel:
    """Build 20 square hollow sections of 60 mm, five wide and four high, with open ends."""
    edge, wall, wide, high, length = 0.06, 0.004, 5, 4, 6.0
    parts: list[Part] = []
    for row in range(high):
        for column in range(wide):
            y, z = (column - (wide - 1) / 2) * edge, (row - (high - 1) / 2) * edge
            for side in (-1.0, 1.0):
                parts.append(box_part((length, wall, edge), (0.0, y + side * (edge - wall) / 2, z), "steel_grey"))
                level = z + side * (edge - wall) / 2
                parts.append(box_part((length, edge - 2 * wall, wall), (0.0, y, level), "steel_grey"))
    return _bundle(name, 526, (length, wide * edge, high * edge), parts, 620.0)


def timber_pack(name: str = "timber_pack") -> ObjectModel:
    """Build a pack of 24 boards of 4 m, 40 x 120 mm, three wide and eight high."""
    width, height, length = 0.12, 0.04, 4.0
    parts = [
        box_part(
            (length - 0.04 * ((row * 7 + column * 3) % 3), width - 0.003, height),
            (0.0, (column - 1) * width, (row - 3.5) * height),
            "pallet_wood_new" if (row + column) % 2 else "pallet_wood",
        )
        for row in range(8)
        for column in range(3)
    ]
    size = (length, 3 * width - 0.003, 8 * height)
    return _bundle(name, 527, size, parts, 230.0)


def panel_pack(name: str = "panel_pack") -> ObjectModel:
    """Build a pack of 18 chipboard panels of 2.5 x 1.1 m, 19 mm."""
    length, width, sheet, count = 2.5, 1.1, 0.019, 18
    parts = [
        box_part(
            (length - 0.004 * (number % 2), width - 0.004 * (number % 2), sheet),
            (0.0, 0.0, (number - (count - 1) / 2) * sheet),
            "wood_broken",
        )
        for number in range(count)
    ]
    return _bundle(name, 528, (length, width, count * sheet), parts, 610.0)


def _pipes(name: str, obj_id: int, diameter: float, wide: int, high: int, material: str, mass: float) -> ObjectModel:
    """Pack pipes hexagonally; rows have ``wide`` and ``wide`` - 1 pipes in turn."""
    length, rise = 6.0, diameter * float(np.sqrt(0.75))
    height = diameter + (high - 1) * rise
    tube = unit_tube(0.92, 16)
    parts = []
    for row in range(high):
        count = wide - row % 2
        for number in range(count):
            y = (number - (count - 1) / 2) * diameter
            z = -height / 2 + diameter / 2 + row * rise
            parts.append(solid_part(tube, (diameter, diameter, length), (0.0, y, z), material, _ALONG_X))
    return _bundle(name, obj_id, (length, wide * diameter, height), parts, 90.0 * len(parts) * diameter * 4)


def _bundle(name: str, obj_id: int, size: tuple[float, float, float], parts: list[Part], mass: float) -> ObjectModel:
    """Return goods that lie on the arms as they are; the collision box is the whole."""
    return model_of(name, "long_goods", obj_id, size, fused(parts), mass=mass)


LONG_GOODS = ("pipe_bundle", "plastic_pipe_bundle", "section_bundle", "timber_pack", "panel_pack")
"""Catalog names."""
