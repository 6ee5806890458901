"""The package's own objects by name, each with its builder."""

from warehouse_sim.catalog.building import BUILDING
from warehouse_sim.catalog.clutter import CLUTTER
from warehouse_sim.catalog.loads import LOADS
from warehouse_sim.catalog.pallets import PALLETS
from warehouse_sim.catalog.racks import RACKS
from warehouse_sim.catalog.traffic import TRAFFIC

SHIPPED = {
    **dict.fromkeys(PALLETS, "warehouse_sim.catalog.pallets:pallet"),
    **LOADS,
    **RACKS,
    **BUILDING,
    **TRAFFIC,
    **CLUTTER,
}
"""Name -> builder. What is sampled by class is sampled from these, whatever is installed."""
