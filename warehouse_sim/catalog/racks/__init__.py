"""Selective pallet racking: upright frames, beams and what hangs on them, in a few fixed sizes.

Frame of all: x along the aisle, y into the rack, z up, origin at the centre of the bounding box. A bay is 2.7 m clear
between uprights: three EPAL 1 pallets short side out with four gaps of 75 mm.
"""

from warehouse_sim.catalog.racks.accessories import DECK_DEPTH, DECK_WIDTH, GUARD_HEIGHT
from warehouse_sim.catalog.racks.beams import (
    BAY_WIDTH,
    BAY_WIDTHS,
    BEAM_BUILDERS,
    BEAM_DEPTH,
    BEAM_HEIGHT,
    CONNECTOR_HEIGHT,
    CONNECTOR_LEG,
    CONNECTOR_SHEET,
    STEP_BEAM_DEPTH,
    STEP_DEPTH,
    STEP_HEIGHT,
    rack_beam,
    step_beam,
)
from warehouse_sim.catalog.racks.frame import FRAME_DEPTH, FRAME_HEIGHTS, rack_frame
from warehouse_sim.catalog.racks.upright import HOLE_PITCH, UPRIGHT_DEPTH, UPRIGHT_WIDTH

_ROOM = "warehouse_sim.catalog.racks"
RACKS = {
    **dict.fromkeys(FRAME_HEIGHTS, f"{_ROOM}.frame:rack_frame"),
    **{name: f"{_ROOM}.beams:{builder.__name__}" for name, builder in BEAM_BUILDERS.items()},
    **{
        name: f"{_ROOM}.accessories:{name}"
        for name in (
            "mesh_deck",
            "pallet_support_bar",
            "upright_guard",
            "rack_end_guard",
            "load_notice",
            "beam_label",
            "frame_label",
            "row_spacer",
        )
    },
}
"""Catalog name -> where its builder is."""

__all__ = [
    "BAY_WIDTH",
    "BAY_WIDTHS",
    "BEAM_DEPTH",
    "BEAM_HEIGHT",
    "CONNECTOR_HEIGHT",
    "CONNECTOR_LEG",
    "CONNECTOR_SHEET",
    "DECK_DEPTH",
    "DECK_WIDTH",
    "FRAME_DEPTH",
    "FRAME_HEIGHTS",
    "GUARD_HEIGHT",
    "HOLE_PITCH",
    "RACKS",
    "STEP_BEAM_DEPTH",
    "STEP_DEPTH",
    "STEP_HEIGHT",
    "UPRIGHT_DEPTH",
    "UPRIGHT_WIDTH",
    "rack_beam",
    "rack_frame",
    "step_beam",
]
