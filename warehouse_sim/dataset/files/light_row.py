"""A light as records name it."""

from typing import Any

from warehouse_sim.schema import Light


def light_row(light: Light) -> dict[str, Any]:
    """Return plain data of a light; of a distribution the name of its file, and how it is turned."""
    row = dict(vars(light))
    distribution, along = row.pop("distribution"), row.pop("along")
    return row if distribution is None else row | {"distribution": distribution.name, "along": along}
