"""A storage platform (mezzanine): a deck in panels on columns, with a railing.

Frame of all: z up, origin at the centre of the bounding box.
"""

from warehouse_sim.catalog.parts import box_part, collision_boxes, fused, model_of
from warehouse_sim.schema import ObjectModel

PANEL = (2.06, 2.4, 0.3)
"""Edges of a panel of deck with its beams (m); as long as two bays of shelving."""
COLUMN_HEIGHT = 2.5
"""Free height under the beams (m)."""
DECK_TOP = COLUMN_HEIGHT + PANEL[2]
"""Height of the deck above the floor (m)."""


def platform_panel(name: str = "platform_panel") -> ObjectModel:
    """Build a panel: 38 mm of board on two edge beams and three joists."""
    length, width, height = PANEL
    board = 0.038
    parts = [box_part((length, width, board), (0.0, 0.0, (height - board) / 2), "wood_broken")]
    low = -board / 2
    parts += [
        box_part((length, 0.1, height - board), (0.0, side * (width - 0.1) / 2, low), "steel_grey")
        for side in (-1.0, 1.0)
    ]
    parts += [
        box_part((0.06, width - 0.2, 0.16), (x, 0.0, height / 2 - board - 0.08), "steel_grey") for x in (-0.7, 0.0, 0.7)
    ]
    return model_of(name, "rack", 540, PANEL, fused(parts), collision_boxes(parts), turns=2)


def platform_column(name: str = "platform_column") -> ObjectModel:
    """Build a square column of 100 mm with foot and head plates."""
    height, plate = COLUMN_HEIGHT, 0.012
    parts = [box_part((0.1, 0.1, height - 2 * plate), (0.0, 0.0, 0.0), "steel_grey")]
    parts += [
        box_part((0.2, 0.2, plate), (0.0, 0.0, side * (height - plate) / 2), "steel_grey") for side in (-1.0, 1.0)
    ]
    return model_of(name, "rack", 541, (0.2, 0.2, height), fused(parts), collision_boxes(parts), turns=4)


def platform_railing(name: str = "platform_railing") -> ObjectModel:
    """Build a panel's length of railing: posts, hand rail at 1.1 m, knee rail and toe board (EN ISO 14122-3)."""
    length, height = PANEL[0], 1.1
    parts = [box_part((0.04, 0.04, height - 0.04), (x, 0.0, -0.02), "guard_yellow") for x in (-1.01, 0.0, 1.01)]
    parts.append(box_part((length, 0.04, 0.04), (0.0, 0.0, height / 2 - 0.02), "guard_yellow"))
    for x in (-0.505, 0.505):
        parts.append(box_part((0.97, 0.03, 0.03), (x, 0.0, 0.0), "guard_yellow"))
        parts.append(box_part((0.97, 0.006, 0.1), (x, 0.0, -height / 2 + 0.05), "guard_yellow"))
    return model_of(name, "rack", 542, (length, 0.04, height), fused(parts), collision_boxes(parts), turns=2)
