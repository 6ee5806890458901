"""Look at a dataset that anyone made: what it counts, what is odd in it, and what its images show."""

from warehouse_sim.dataset.inspect.report import inspect

__all__ = ["inspect"]
