"""From one format into others, on disk."""

from warehouse_sim.dataset.convert.run import convert

__all__ = ["convert"]
