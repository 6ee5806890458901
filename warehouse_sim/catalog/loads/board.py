"""What goes under and around a load: slip sheets and corner posts of solid board.

Slip sheets of kraft board are 0.6-1.5 mm thick; as a layer on a pallet they have its size and no tabs. Corner posts are
angles of laminated board, commonly 50 x 50 mm and 3-6 mm thick. Solid board weighs about 700-800 kg/m^3.
"""

import numpy as np

from warehouse_sim.catalog.parts import box_part, collision_boxes, model_of, slab_part
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.schema import ObjectModel

SHEET = 0.0015
"""Thickness of a slip sheet (m)."""
POST_LEG, POST_BOARD = 0.05, 0.004
"""Width of a post's legs and thickness of its board (m)."""
_DENSITY = 750.0

SLIP_SHEETS = {
    f"slip_sheet_{round(1000 * length)}x{round(1000 * width)}": (obj_id, length, width)
    for obj_id, length, width in ((40, 1.2, 0.8), (41, 1.2, 1.0), (42, 1.219, 1.016), (43, 0.8, 0.6))
}
"""Catalog name -> obj_id, length and width (m)."""
CORNER_POSTS = {
    f"corner_post_{round(1000 * h)}": (44 + i, h) for i, h in enumerate(np.round(np.arange(0.3, 1.75, 0.1), 3))
}
"""Catalog name -> obj_id and height (m)."""


def slip_sheet(name: str) -> ObjectModel:
    """Build the sheet called ``name`` ("slip_sheet_1200x800")."""
    obj_id, length, width = SLIP_SHEETS[name]
    size = (length, width, SHEET)
    sheet = box_part(size, (0.0, 0.0, 0.0), "kraft_dark")
    return model_of(
        name,
        "slip_sheet",
        obj_id,
        size,
        (sheet,),
        collision_boxes((sheet,)),
        mass=_DENSITY * length * width * SHEET,
        symmetry=SymmetryGroup.cuboid(),
    )


def corner_post(name: str) -> ObjectModel:
    """Build the post called ``name`` ("corner_post_1000"); its corner is at -x -y and its legs reach to +x and +y.

    It has no collision boxes: the wrap holds it, so it stands where the load's corner is.
    """
    obj_id, height = CORNER_POSTS[name]
    half, board = POST_LEG / 2, POST_BOARD
    outline = ((-half, -half), (half, -half), (half, board - half), (board - half, board - half), (board - half, half),
               (-half, half))  # fmt: skip
    return model_of(
        name,
        "corner_post",
        int(obj_id),
        (POST_LEG, POST_LEG, height),
        (slab_part(outline, -height / 2, height / 2, "board_white"),),
        (),
        mass=_DENSITY * float(height) * board * (2 * POST_LEG - board),
    )
