"""Pallets that have been through a lot."""

import numpy as np

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.pallets.wear.damaged import WearConfig, damaged
from warehouse_sim.schema import ObjectModel, Part

KINDS = ("epal1", "epal2", "epal3", "epal6", "epal7", "gma_48x40", "blue_block_1200x1000")


def ruined(name: str, seed: int, wear: WearConfig) -> ObjectModel:
    """Return the catalog object ``name`` after ``wear``."""
    return damaged(catalog_object(name), wear, np.random.default_rng([7, seed]))


def wood(model: ObjectModel) -> list[Part]:
    """Return the boards and blocks, without what lies on them."""
    return [part for part in model.parts if part.material.startswith(("pallet", "galvanised", "plastic"))]


def made(name: str, **wear: float) -> ObjectModel:
    """Return the catalog object ``name`` after wear by its fields, the same each time."""
    return damaged(catalog_object(name), WearConfig(**wear), np.random.default_rng(3))


def of_material(model: ObjectModel, material: str) -> list[Part]:
    """Return the parts of one material."""
    return [part for part in model.parts if part.material == material]
