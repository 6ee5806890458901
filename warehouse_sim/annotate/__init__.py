"""Pure functions from what was rendered, and the scene behind it, to labels."""

from warehouse_sim.annotate.labels import annotate, targets_in_view

__all__ = ["annotate", "targets_in_view"]
