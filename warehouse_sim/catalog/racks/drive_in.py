"""Drive-in racking: rails along both sides of a lane, on which pallets stand one behind the other, long side out.

Frame of both pieces: x across the lane, y along it, z up, origin at the centre of the bounding box.
"""

from warehouse_sim.catalog.parts import box_part, collision_boxes, fused, model_of
from warehouse_sim.schema import ObjectModel

LANE_WIDTH = 1.35
"""Clear width between the frames (m): 1.2 m of pallet and 75 mm of play on each side (FEM 10.2.07)."""
PLACE_PITCH = 0.95
"""Distance from pallet to pallet along a lane (m), the length of a rail's piece."""
RAIL_HEIGHT = 0.14
"""From the underside of a rail to the surface that carries the pallet (m)."""
_EDGE = 0.04
"""Height of the guiding edge over that surface (m)."""
_LEDGE, _SHEET = 0.17, 0.004


def drive_in_rail(name: str = "drive_in_rail") -> ObjectModel:
    """Build a piece of rail for the left side of a lane: web at -x, ledge towards +x, a guiding edge above it."""
    height = RAIL_HEIGHT + _EDGE
    z_ledge = height / 2 - _EDGE - _SHEET / 2
    web = box_part((_SHEET, PLACE_PITCH, height), ((_SHEET - _LEDGE) / 2, 0.0, 0.0), "rack_orange")
    ledge = box_part((_LEDGE - _SHEET, PLACE_PITCH, _SHEET), (_SHEET / 2, 0.0, z_ledge), "rack_orange")
    lip = box_part(
        (_SHEET, PLACE_PITCH, 0.05), ((_LEDGE - _SHEET) / 2, 0.0, z_ledge - _SHEET / 2 - 0.025), "rack_orange"
    )
    # The arm that carries the rail at its middle, a welded plate.
    arm = box_part(
        (_LEDGE - 2 * _SHEET, 0.006, RAIL_HEIGHT - _SHEET), (0.0, 0.0, z_ledge - RAIL_HEIGHT / 2), "rack_orange"
    )
    parts = [web, ledge, lip, arm]
    return model_of(name, "rack", 506, (_LEDGE, PLACE_PITCH, height), fused(parts), collision_boxes(parts))


def drive_in_tie(name: str = "drive_in_tie") -> ObjectModel:
    """Build the beam that ties the frames of both sides of a lane together above the loads."""
    size = (LANE_WIDTH, 0.05, 0.1)
    parts = [box_part(size, (0.0, 0.0, 0.0), "rack_orange")]
    return model_of(name, "rack", 507, size, fused(parts), collision_boxes(parts), turns=2)
