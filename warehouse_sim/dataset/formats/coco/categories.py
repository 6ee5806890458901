"""COCO categories: a class has the same number in every dataset."""

from collections.abc import Iterable
from typing import Any

from warehouse_sim.annotate.occluders import kind_of

# The place in this list is the number of the class: new ones come last, none is ever taken out.
_CLASSES = (
    *("pallet", "carton", "tote", "drum", "sack", "slip_sheet", "corner_post", "wrap", "gitterbox", "roll_container"),
    *("octabin", "big_bag", "ibc", "long_goods", "rack", "guard", "person", "forklift", "pallet_jack", "tugger"),
    *("cart", "amr", "cone", "bollard", "sign", "clutter", "floor", "wall", "ceiling", "column"),
    *("door", "dock", "trailer", "marking", "luminaire", "conveyor", "bin", "fire_equipment"),
)
_NUMBERS = {name: number for number, name in enumerate(_CLASSES, start=1)}
_FIRST_OTHER = 1001
_STUFF = frozenset(("floor", "wall", "ceiling", "marking"))


def category_numbers(names: Iterable[str]) -> dict[str, int]:
    """Return the number of each class, in order of the numbers.

    Classes that the package does not know come from 1001 on, in alphabetical order of those of the dataset.
    """
    others = sorted(set(names) - set(_NUMBERS))
    known = sorted(set(names) & set(_NUMBERS), key=_NUMBERS.__getitem__)
    return {name: _NUMBERS[name] for name in known} | {name: _FIRST_OTHER + i for i, name in enumerate(others)}


def is_stuff(name: str) -> bool:
    """Return whether all of a class in an image is one segment, as of floors: what cannot be counted."""
    return name in _STUFF


def category_row(name: str, number: int, panoptic: bool) -> dict[str, Any]:
    """Return an entry of ``categories``."""
    row = {"id": number, "name": name, "supercategory": kind_of(name)}
    return row | {"isthing": int(not is_stuff(name))} if panoptic else row
