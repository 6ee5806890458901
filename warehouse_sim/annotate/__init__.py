"""Pure functions from what was rendered, and the scene behind it, to labels."""

from warehouse_sim.annotate.in_view import targets_in_view
from warehouse_sim.annotate.labels import annotate

__all__ = ["annotate", "targets_in_view"]
