"""What use does to a pallet: its look and its boards change, its meaning does not."""

from warehouse_sim.catalog.pallets.wear.worn import WearConfig, worn

__all__ = ["WearConfig", "worn"]
