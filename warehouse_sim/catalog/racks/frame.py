"""Upright frames: two perforated uprights on base plates, laced by horizontals and diagonals.

Frame of it: x along the aisle, y into the rack, z up, origin at the centre of the bounding box.
"""

import numpy as np

from warehouse_sim.catalog.parts import box_part, collision_boxes, fused, mesh_part, model_of, solid_box, solid_part
from warehouse_sim.catalog.racks.upright import UPRIGHT_DEPTH, UPRIGHT_WIDTH, upright_mesh
from warehouse_sim.geometry.pose import rotation_x, rotation_z
from warehouse_sim.geometry.solids import unit_cylinder
from warehouse_sim.schema import ObjectModel, Part

FRAME_DEPTH = 1.1
"""Outer depth of a frame (m); a 1.2 m deep pallet overhangs it by 50 mm front and back."""

_LACING_PITCH = 0.6
_PLATE = (0.15, UPRIGHT_DEPTH + 0.04, 0.006)
_OBJ_IDS = {
    2000: 101,
    2500: 102,
    3500: 103,
    4500: 104,
    5500: 105,
    6500: 106,
    8000: 107,
    9500: 500,
    11000: 501,
    13000: 502,
}
"""Height (mm) -> obj_id."""

FRAME_HEIGHTS = {f"rack_frame_{mm}": mm / 1000 for mm in _OBJ_IDS}
"""Catalog name -> height (m), lowest first."""


def rack_frame(name: str) -> ObjectModel:
    """Build an upright frame."""
    height = FRAME_HEIGHTS[name]
    mesh, offset = upright_mesh(height), (FRAME_DEPTH - UPRIGHT_DEPTH) / 2
    front = mesh_part(mesh, "rack_blue", (0.0, -offset, 0.0))
    back = mesh_part(mesh, "rack_blue", (0.0, offset, 0.0), rotation_z(np.pi))
    uprights = [solid_box((UPRIGHT_WIDTH, UPRIGHT_DEPTH, height), (0.0, side * offset, 0.0)) for side in (-1.0, 1.0)]
    lacing = _lacing(height)
    plates = [box_part(_PLATE, (0.0, side * offset, (_PLATE[2] - height) / 2), "galvanised") for side in (-1.0, 1.0)]
    return model_of(
        name,
        "rack",
        _OBJ_IDS[round(1000 * height)],
        (_PLATE[0], FRAME_DEPTH + _PLATE[1] - UPRIGHT_DEPTH, height),
        (front, back, *fused([*plates, *_anchors(height, offset), *lacing])),
        (*uprights, *collision_boxes(plates + lacing)),
    )


def _anchors(height: float, offset: float) -> list[Part]:
    """Return the two bolts, M12 with 19 mm heads, that hold each base plate."""
    z = -height / 2 + _PLATE[2] + 0.004
    return [
        solid_part(unit_cylinder(8), (0.019, 0.019, 0.008), (x, side * offset, z), "galvanised")
        for side in (-1.0, 1.0)
        for x in (-0.0625, 0.0625)
    ]


def _lacing(height: float) -> list[Part]:
    """Return horizontals at both ends and diagonals in a zigzag between the uprights' inner faces."""
    span = FRAME_DEPTH - 2 * UPRIGHT_DEPTH
    low, high = -height / 2 + 0.15, height / 2 - 0.15
    bars = [box_part((0.03, span, 0.03), (0.0, 0.0, z), "galvanised") for z in (low, high)]
    count = max(1, round((high - low) / _LACING_PITCH))
    pitch = (high - low) / count
    # The bar's corners, not its axis, must stay between the uprights.
    length = np.hypot(span, pitch) - 0.03
    for index in range(count):
        rising = 1.0 if index % 2 == 0 else -1.0
        rotation = rotation_x(rising * np.arctan2(pitch, span))
        bars.append(box_part((0.025, length, 0.025), (0.0, 0.0, low + (index + 0.5) * pitch), "galvanised", rotation))
    return bars
