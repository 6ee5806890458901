"""What stands around the racks: the hall's shell and structure, luminaires, docks, conveyors and what is on the floor.

Origin at the centre of the bounding box, z up.
"""

from warehouse_sim.catalog.building.conveyor import CONVEYORS
from warehouse_sim.catalog.building.dock import DOOR_SIZE, LEVELLER_SIZE, OPEN_DOOR_SIZE, SEAL_SIZE, TRAILER_SIZE
from warehouse_sim.catalog.building.markings import LINE_WIDTH, LINES, PAINT, TYRE_TRACK
from warehouse_sim.catalog.building.safety import AISLE_SIGNS, FLOOR_LABELS, GATE_SIZE
from warehouse_sim.catalog.building.shell import (
    FLOOR_SIZE,
    MODULE_LENGTH,
    OPENING_HEIGHT,
    OPENING_WIDTH,
    WALL_SIZE,
    floor_slab,
    wall,
)
from warehouse_sim.catalog.building.structure import CEILING_SIZE, TRUSS_SIZE, highbay_luminaire

_HERE = "warehouse_sim.catalog.building"
BUILDING = {
    name: f"{_HERE}.{place}"
    for name, place in {
        "floor_slab": "shell:floor_slab",
        "floor_slab_jointed": "shell:jointed_slab",
        "floor_slab_epoxy": "shell:jointed_slab",
        "wall": "shell:wall",
        "wall_clad": "shell:clad_wall",
        "wall_module": "shell:wall_module",
        "wall_module_dock": "shell:dock_wall_module",
        "column_steel": "structure:steel_column",
        "column_concrete": "structure:concrete_column",
        "column_guard": "structure:column_guard",
        "ceiling": "structure:ceiling",
        "roof_truss": "structure:roof_truss",
        "highbay_luminaire": "structure:highbay_luminaire",
        "luminaire_round": "structure:round_luminaire",
        "luminaire_trunking": "structure:trunking_luminaire",
        "dock_door_closed": "dock:closed_door",
        "dock_door_open": "dock:open_door",
        "dock_leveller": "dock:leveller",
        "dock_bumper": "dock:bumper",
        "dock_seal": "dock:seal",
        "trailer": "dock:trailer",
        "drive_in_door": "safety:drive_in_door",
        "corner_marking": "markings:corner_marking",
        "keep_clear_marking": "markings:keep_clear_marking",
        "crossing_marking": "markings:crossing_marking",
        "tyre_mark_straight": "markings:straight_tyre_mark",
        "tyre_mark_curve": "markings:curved_tyre_mark",
        **dict.fromkeys(LINES, "markings:lane_line"),
        "extinguisher": "safety:extinguisher",
        "fire_hose_cabinet": "safety:fire_hose_cabinet",
        "fire_sign": "safety:fire_sign",
        "exit_sign": "safety:exit_sign",
        "mandatory_sign": "safety:mandatory_sign",
        "rubbish_bin": "safety:rubbish_bin",
        "guard_rail": "safety:guard_rail",
        **dict.fromkeys(AISLE_SIGNS, "safety:aisle_sign"),
        **dict.fromkeys(FLOOR_LABELS, "safety:floor_label"),
        **dict.fromkeys(CONVEYORS, "conveyor:conveyor"),
    }.items()
}
"""Catalog name -> where its builder is."""

__all__ = [
    "AISLE_SIGNS",
    "BUILDING",
    "CEILING_SIZE",
    "CONVEYORS",
    "DOOR_SIZE",
    "FLOOR_LABELS",
    "FLOOR_SIZE",
    "GATE_SIZE",
    "LEVELLER_SIZE",
    "LINES",
    "LINE_WIDTH",
    "MODULE_LENGTH",
    "OPENING_HEIGHT",
    "OPENING_WIDTH",
    "OPEN_DOOR_SIZE",
    "PAINT",
    "SEAL_SIZE",
    "TRAILER_SIZE",
    "TRUSS_SIZE",
    "TYRE_TRACK",
    "WALL_SIZE",
    "floor_slab",
    "highbay_luminaire",
    "wall",
]
