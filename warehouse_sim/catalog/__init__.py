"""Parametric objects to real standards: pallets, cartons, racks, the building and what their surfaces are made of."""

from functools import cache

from warehouse_sim.catalog.building import floor_slab, highbay_luminaire, wall
from warehouse_sim.catalog.cartons import SKUS, carton
from warehouse_sim.catalog.materials import materials
from warehouse_sim.catalog.pallets import epal1
from warehouse_sim.catalog.racks import FRAME_HEIGHTS, rack_beam, rack_frame
from warehouse_sim.registry import Registry
from warehouse_sim.schema import ObjectModel

CATALOG = Registry("catalog object")
"""Name -> builder: a function that takes the name and returns the ``ObjectModel``."""

for _name in ("epal1", "epal1_new", "epal1_grey"):
    CATALOG.add(_name, "warehouse_sim.catalog.pallets:epal1")
for _name in SKUS:
    CATALOG.add(_name, "warehouse_sim.catalog.cartons:carton")
for _name in FRAME_HEIGHTS:
    CATALOG.add(_name, "warehouse_sim.catalog.racks:rack_frame")
CATALOG.add("rack_beam_2700", "warehouse_sim.catalog.racks:rack_beam")
for _name in ("floor_slab", "wall", "highbay_luminaire"):
    CATALOG.add(_name, f"warehouse_sim.catalog.building:{_name}")


def catalog_names() -> list[str]:
    """Return the names of all catalog objects, sorted."""
    return CATALOG.names()


@cache
def catalog_object(name: str) -> ObjectModel:
    """Return the catalog object called ``name``; the same object each time, so that scenes share geometry.

    Raises:
        UnknownNameError: The name is not registered.
    """
    return CATALOG.get(name)(name)


__all__ = [
    "CATALOG",
    "carton",
    "catalog_names",
    "catalog_object",
    "epal1",
    "floor_slab",
    "highbay_luminaire",
    "materials",
    "rack_beam",
    "rack_frame",
    "wall",
]
