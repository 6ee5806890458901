"""What stands on pallets: cartons, euro containers, drums, sacks, carriers of their own, and what secures them."""

from warehouse_sim.catalog.loads.board import CORNER_POSTS, SLIP_SHEETS
from warehouse_sim.catalog.loads.carriers import CARRIERS
from warehouse_sim.catalog.loads.cartons import carton
from warehouse_sim.catalog.loads.drums import DRUMS
from warehouse_sim.catalog.loads.open_cartons import OPEN_CARTONS
from warehouse_sim.catalog.loads.sacks import SACK_SHAPES, SACKS
from warehouse_sim.catalog.loads.skus import ALL_SKUS, HEAVY_SKUS, SKUS
from warehouse_sim.catalog.loads.totes import TOTES
from warehouse_sim.catalog.loads.wrap import WRAPS

LOADS = {
    name: f"warehouse_sim.catalog.loads.{target}"
    for names, target in (
        (ALL_SKUS, "cartons:carton"),
        (OPEN_CARTONS, "open_cartons:open_carton_of"),
        (TOTES, "totes:tote"),
        (DRUMS, "drums:drum"),
        (SACKS, "sacks:sack"),
        (SACK_SHAPES, "sacks:sack"),
        (SLIP_SHEETS, "board:slip_sheet"),
        (CORNER_POSTS, "board:corner_post"),
        (WRAPS, "wrap:wrap"),
    )
    for name in names
} | {name: f"warehouse_sim.catalog.loads.carriers.{target}" for name, target in CARRIERS.items()}
"""Catalog name -> builder of everything in this folder, as the registry names it."""

__all__ = [
    "ALL_SKUS",
    "CARRIERS",
    "CORNER_POSTS",
    "DRUMS",
    "HEAVY_SKUS",
    "LOADS",
    "SACKS",
    "SACK_SHAPES",
    "SKUS",
    "SLIP_SHEETS",
    "TOTES",
    "WRAPS",
    "carton",
]
