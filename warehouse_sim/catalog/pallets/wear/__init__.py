"""What use does to a pallet: its look and its boards change, its meaning does not."""

from warehouse_sim.catalog.pallets.wear.damaged import WearConfig, damaged

__all__ = ["WearConfig", "damaged"]
