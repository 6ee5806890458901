"""Cantilever racking for long goods: columns on a foot, with arms on one side.

Frame of a column: x along the aisle, y from the arms' free end to the column, z up, origin at the centre of the
bounding box.
"""

import numpy as np

from warehouse_sim.catalog.parts import box_part, collision_boxes, fused, model_of
from warehouse_sim.schema import ObjectModel

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
