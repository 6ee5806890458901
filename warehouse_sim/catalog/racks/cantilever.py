"""Cantilever racking, columns on a foot with arms on one side, and its long goods: pipes, sections, boards, sheets.

Frame of a column: x along the aisle, y from the arms' free end to the column, z up, origin at the centre of the
bounding box; of goods: x along them. Lengths are those of the trade: tubes 6 m, construction timber 4 m and 5 m, panels
2.5 x 1.25 m.
"""

import numpy as np

from warehouse_sim.catalog.parts import box_part, collision_boxes, fused, model_of, solid_part
from warehouse_sim.geometry.solids import unit_tube
from warehouse_sim.schema import ObjectModel, Part

ARM_LENGTH, ARM_HEIGHT = 1.2, 0.1
"""Free length of an arm and its height at the column (m)."""
COLUMN = (0.12, 0.22)
"""Section of a column along x and y (m)."""
ARM_PITCH = 0.9
"""Distance from arm to arm (m)."""
FOOT_TOP = 0.24
"""Height of the foot's top above the floor (m), the lowest level."""
CANTILEVERS = {f"cantilever_column_{levels}": levels for levels in (3, 4, 5)}
"""Catalog name -> levels, the foot's included."""


def level_heights(levels: int) -> list[float]:
    """Return the heights (m) above the floor of what carries the goods."""
    return [FOOT_TOP + number * ARM_PITCH for number in range(levels)]


def cantilever_column(name: str) -> ObjectModel:
    """Build a column with its foot and arms; arms have a stop at their end and taper in two steps."""
    levels = CANTILEVERS[name]
    tops = level_heights(levels)
    height = tops[-1] + 0.5
    depth = ARM_LENGTH + COLUMN[1]
    y_column, floor = (depth - COLUMN[1]) / 2, -height / 2
    y_arm = -COLUMN[1] / 2
    # An I-section: two flanges and a web.
    flange, web = 0.012, 0.008
    parts = [
        box_part((COLUMN[0], flange, height), (0.0, y_column + side * (COLUMN[1] - flange) / 2, 0.0), "rack_blue")
        for side in (-1.0, 1.0)
    ]
    parts.append(box_part((web, COLUMN[1] - 2 * flange, height), (0.0, y_column, 0.0), "rack_blue"))
    parts.append(box_part((0.12, ARM_LENGTH, FOOT_TOP), (0.0, y_arm, floor + FOOT_TOP / 2), "rack_blue"))
    for top in tops[1:]:
        inner, outer = 0.6 * ARM_LENGTH, 0.4 * ARM_LENGTH
        y_inner = y_arm + (ARM_LENGTH - inner) / 2
        parts.append(box_part((0.06, inner, ARM_HEIGHT), (0.0, y_inner, floor + top - ARM_HEIGHT / 2), "rack_orange"))
        y_outer = y_arm - (ARM_LENGTH - outer) / 2
        parts.append(box_part((0.06, outer, 0.06), (0.0, y_outer, floor + top - 0.03), "rack_orange"))
        parts.append(box_part((0.08, 0.012, 0.1), (0.0, -depth / 2 + 0.006, floor + top + 0.05), "rack_orange"))
    return model_of(name, "rack", 517 + levels, (COLUMN[0], depth, height), fused(parts), collision_boxes(parts))


def cantilever_brace(name: str = "cantilever_brace") -> ObjectModel:
    """Build the horizontal tie between two columns 1.5 m apart: a channel of 80 x 40 mm."""
    size = (1.5 - COLUMN[0], 0.04, 0.08)
    parts = [box_part(size, (0.0, 0.0, 0.0), "galvanised")]
    return model_of(name, "rack", 523, size, fused(parts), collision_boxes(parts), turns=2)


def arm_places(widths: list[float], gap: float = 0.04) -> list[float]:
    """Return y (m), from the arms' free end, of the middles of goods of ``widths`` (m) side by side on an arm."""
    edges = np.cumsum([0.0, *(width + gap for width in widths)])
    start = (ARM_LENGTH - (edges[-1] - gap)) / 2
    return [float(start + edge + width / 2) for edge, width in zip(edges[:-1], widths, strict=True)]


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
