"""Pallets: wooden ones board by board, plastic ones as moulded, each with every pocket that forks can enter.

Frame of all: origin at the centre of the bounding box, x along the longer edge, z up.
"""

from collections.abc import Callable

from warehouse_sim.catalog.pallets import block_pallet, plans, plastic, stringer_pallet
from warehouse_sim.catalog.pallets.wear import WearConfig, damaged
from warehouse_sim.errors import UnknownNameError
from warehouse_sim.schema import ObjectModel

LENGTH, WIDTH, HEIGHT = 1.2, 0.8, 0.144
"""Outer edges of the EPAL 1 pallet (m)."""

_USED, _NEW, _GREY = (
    ("pallet_wood", "pallet_block"),
    ("pallet_wood_new", "pallet_block"),
    ("pallet_wood_grey", "pallet_block_grey"),
)

PALLETS: dict[str, Callable[[str], ObjectModel]] = {
    "epal1": lambda name: block_pallet.build(plans.EPAL1, name, *_USED),
    "epal1_new": lambda name: block_pallet.build(plans.EPAL1, name, *_NEW),
    "epal1_grey": lambda name: block_pallet.build(plans.EPAL1, name, *_GREY),
    "epal2": lambda name: block_pallet.build(plans.EPAL2, name, *_USED),
    "epal3": lambda name: block_pallet.build(plans.EPAL3, name, *_USED),
    "epal6": lambda name: block_pallet.build(plans.EPAL6, name, *_USED),
    "epal7": lambda name: block_pallet.build(plans.EPAL7, name, *_USED),
    "gma_48x40": lambda name: stringer_pallet.build(name, "pallet_wood", "pallet_wood"),
    "blue_block_1200x1000": lambda name: block_pallet.build(plans.BLUE_BLOCK, name, "pallet_blue", "pallet_blue"),
    "plastic_runners": lambda name: plastic.on_runners(name, "plastic_grey"),
    "plastic_runners_blue": lambda name: plastic.on_runners(name, "plastic_blue"),
    "plastic_nestable": lambda name: plastic.on_feet(name, "plastic_black"),
    "plastic_nestable_grey": lambda name: plastic.on_feet(name, "plastic_grey"),
}
"""Catalog name -> builder; looks of one geometry share its obj_id."""


_EPAL1_LOOKS = ("epal1", "epal1_new", "epal1_grey")


def pallet(name: str) -> ObjectModel:
    """Build the pallet called ``name``.

    Raises:
        UnknownNameError: ``name`` is not in ``PALLETS``.
    """
    if name not in PALLETS:
        raise UnknownNameError("pallet", name, list(PALLETS))
    return PALLETS[name](name)


def epal1(name: str = "epal1") -> ObjectModel:
    """Build the EPAL 1 pallet; its three looks ("epal1", "epal1_new", "epal1_grey") are one geometry, obj_id 1.

    Raises:
        UnknownNameError: ``name`` is none of the three looks.
    """
    if name not in _EPAL1_LOOKS:
        raise UnknownNameError("look of the EPAL 1 pallet", name, list(_EPAL1_LOOKS))
    return pallet(name)


__all__ = ["HEIGHT", "LENGTH", "PALLETS", "WIDTH", "WearConfig", "damaged", "epal1", "pallet"]
