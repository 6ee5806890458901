"""Racking: selective pallet racks in a few fixed sizes, drive-in and cantilever racks, shelves, platforms.

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
from warehouse_sim.catalog.racks.cantilever import CANTILEVERS
from warehouse_sim.catalog.racks.frame import FRAME_DEPTH, FRAME_HEIGHTS, rack_frame
from warehouse_sim.catalog.racks.long_goods import LONG_GOODS
from warehouse_sim.catalog.racks.shelves import BINS
from warehouse_sim.catalog.racks.upright import HOLE_PITCH, UPRIGHT_DEPTH, UPRIGHT_WIDTH

_HERE = "warehouse_sim.catalog.racks"
RACKS = {
    **dict.fromkeys(FRAME_HEIGHTS, f"{_HERE}.frame:rack_frame"),
    **{name: f"{_HERE}.beams:{builder.__name__}" for name, builder in BEAM_BUILDERS.items()},
    **{
        name: f"{_HERE}.accessories:{name}"
        for name in (
            "mesh_deck",
            "pallet_support_bar",
            "upright_guard",
            "rack_end_guard",
            "beam_label",
            "frame_label",
            "row_spacer",
        )
    },
    "load_notice": f"{_HERE}.accessories:load_notice",
    **{name: f"{_HERE}.drive_in:{name}" for name in ("drive_in_rail", "drive_in_tie")},
    **dict.fromkeys(CANTILEVERS, f"{_HERE}.cantilever:cantilever_column"),
    "cantilever_brace": f"{_HERE}.cantilever:cantilever_brace",
    **{name: f"{_HERE}.long_goods:{name}" for name in LONG_GOODS},
    "shelf_bay": f"{_HERE}.shelves:shelf_bay",
    **dict.fromkeys(BINS, f"{_HERE}.shelves:storage_bin"),
    **{name: f"{_HERE}.platform:{name}" for name in ("platform_panel", "platform_column", "platform_railing")},
}
"""Catalog name -> where its builder is."""

__all__ = [
    "BAY_WIDTH",
    "BAY_WIDTHS",
    "BEAM_DEPTH",
    "BEAM_HEIGHT",
    "BINS",
    "CANTILEVERS",
    "CONNECTOR_HEIGHT",
    "CONNECTOR_LEG",
    "CONNECTOR_SHEET",
    "DECK_DEPTH",
    "DECK_WIDTH",
    "FRAME_DEPTH",
    "FRAME_HEIGHTS",
    "GUARD_HEIGHT",
    "HOLE_PITCH",
    "LONG_GOODS",
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
