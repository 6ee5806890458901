"""Shelving for small parts, the open-fronted bins that stand in it, and the storage platform (mezzanine) over it.

Frame of all: x along the aisle, y into the shelf (the front is at -y), z up, origin at the centre of the bounding box.
"""

import numpy as np

from warehouse_sim.catalog.parts import box_part, collision_boxes, fused, model_of
from warehouse_sim.geometry.pose import rotation_y
from warehouse_sim.schema import ObjectModel

SHELF_SIZE = (1.03, 0.5, 2.2)
"""Outer edges of a bay (m), pitch along x; 1 m of clear width."""
SHELF_SHEET = 0.03
"""Height of a shelf with its folded edge (m)."""
SHELF_COUNT = 6
POST = 0.03
_PAINT = "steel_paint_blue"
_FIRST, _STEP = 0.1, 0.4


def shelf_tops() -> list[float]:
    """Return the heights (m) of the shelves' tops above the foot of a bay."""
    return [_FIRST + _STEP * number for number in range(SHELF_COUNT)]


SHELF_CLEARANCE = _STEP - SHELF_SHEET
"""Free height over a shelf that has another above it (m)."""


def shelf_bay(name: str = "shelf_bay") -> ObjectModel:
    """Build a bay of six shelves on four posts, with a cross of flat bars behind."""
    width, depth, height = SHELF_SIZE
    floor = -height / 2
    posts = [
        box_part(
            (POST / 2, POST, height), (x * (width - POST / 2) / 2, y * (depth - POST) / 2, 0.0), "steel_paint_blue"
        )
        for x in (-1.0, 1.0)
        for y in (-1.0, 1.0)
    ]
    # The cross of bars lies behind the shelves, which end before it.
    shelves = [
        box_part((width - POST, depth - 0.01, SHELF_SHEET), (0.0, -0.005, floor + top - SHELF_SHEET / 2), "galvanised")
        for top in shelf_tops()
    ]
    run, rise = width - POST, height - 0.4
    bars = [
        box_part(
            (float(np.hypot(run, rise)) - 0.06, 0.002, 0.025),
            (0.0, depth / 2 - 0.001 - 0.002 * number, 0.0),
            "galvanised",
            rotation_y(side * float(np.arctan2(rise, run))),
        )
        for number, side in enumerate((-1.0, 1.0))
    ]
    parts = [*posts, *shelves, *bars]
    return model_of(name, "rack", 530, SHELF_SIZE, fused(parts), collision_boxes(parts))


BINS = {
    "storage_bin_blue": (531, "plastic_blue"),
    "storage_bin_red": (532, "plastic_red"),
    "storage_bin_grey": (533, "plastic_grey"),
}
"""Catalog name -> obj_id and material."""


def storage_bin(name: str) -> ObjectModel:
    """Build an open-fronted bin of 150 x 300 x 130 mm with a label at its front and small boxes in it."""
    obj_id, material = BINS[name]
    # Colours are of equal shape; a millimetre tells their numbers apart, as it does makers' series.
    width, depth, height = 0.15, 0.3 + 0.001 * (obj_id - 531), 0.13
    sheet, front = 0.004, 0.07
    floor = -height / 2
    parts = [box_part((width, depth, sheet), (0.0, 0.0, floor + sheet / 2), material)]
    parts += [
        box_part((sheet, depth, height - sheet), (x * (width - sheet) / 2, 0.0, sheet / 2), material)
        for x in (-1.0, 1.0)
    ]
    inner = width - 2 * sheet
    parts.append(box_part((inner, sheet, height - sheet), (0.0, (depth - sheet) / 2, sheet / 2), material))
    y_front = -(depth - sheet) / 2
    parts.append(box_part((inner, sheet - 0.001, front), (0.0, y_front + 0.0005, floor + sheet + front / 2), material))
    parts.append(box_part((0.09, 0.001, 0.04), (0.0, -depth / 2 + 0.0005, floor + 0.04), "label_paper"))
    parts += [
        box_part((0.06, 0.07, 0.05), (x, y, floor + sheet + 0.025), "kraft")
        for x in (-0.034, 0.034)
        for y in (-0.09, 0.0, 0.09)
    ]
    return model_of(name, "bin", obj_id, (width, depth, height), fused(parts), mass=2.0)


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
