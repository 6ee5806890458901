"""Every class of the package's own objects: its number in all formats, its kind, and whether it can be counted."""

import zlib
from collections.abc import Iterable
from typing import Literal

ObjectKind = Literal["load", "pallet", "rack", "traffic", "building", "other"]
"""What objects are of, in a word; "other" are those of classes that only a user has."""

_LISTED: tuple[tuple[ObjectKind, tuple[str, ...]], ...] = (
    ("pallet", ("pallet",)),
    (
        "load",
        (
            *("carton", "tote", "drum", "sack", "slip_sheet", "corner_post", "wrap"),
            *("gitterbox", "roll_container", "octabin", "big_bag", "ibc", "long_goods"),
        ),
    ),
    ("rack", ("rack", "guard")),
    ("traffic", ("person", "forklift", "pallet_jack", "tugger", "cart", "amr", "cone", "bollard", "sign", "clutter")),
    (
        "building",
        (
            *("floor", "wall", "ceiling", "column", "door", "dock", "trailer"),
            *("marking", "luminaire", "conveyor", "bin", "fire_equipment"),
        ),
    ),
    ("load", ("goods",)),
    ("building", ("service", "window", "outdoors")),
    ("pallet", ("pallet_face",)),
)
_KINDS: dict[str, ObjectKind] = {name: kind for kind, names in _LISTED for name in names}
CLASS_NUMBERS: dict[str, int] = {name: number for number, name in enumerate(_KINDS, start=1)}
"""Class -> its number in COCO, PLY, PCD and MCAP, from 1 in the order of the list; 0 is no class.

New classes come last and none is taken out, so that datasets keep their numbers.
"""
_FIRST_OF_OTHERS = 1000
_MOST_OTHERS = 2**30
_STUFF = frozenset(("floor", "wall", "ceiling", "marking"))


def class_number(name: str) -> int:
    """Return the number of a class: that of ``CLASS_NUMBERS``, or one that follows from the name (CRC-32) alone."""
    return CLASS_NUMBERS.get(name) or _FIRST_OF_OTHERS + zlib.crc32(name.encode("utf-8")) % _MOST_OTHERS


def numbered(names: Iterable[str]) -> dict[str, int]:
    """Return the number of each class, in order of the numbers."""
    return {name: class_number(name) for name in sorted(set(names), key=lambda name: (class_number(name), name))}


def mask_values(names: Iterable[str]) -> dict[str, int]:
    """Return what each class is in a 16-bit class mask.

    The package's own have their numbers; those that only a user has, whose numbers may need 31 bits, follow from
    1,000 on in order of these.
    """
    found = numbered(names)
    others = [name for name in found if name not in CLASS_NUMBERS]
    return {name: CLASS_NUMBERS.get(name) or _FIRST_OF_OTHERS + others.index(name) for name in found}


def kind_of(name: str) -> ObjectKind:
    """Return what kind of object a class is; "other" for classes that only a user has."""
    return _KINDS.get(name, "other")


def is_stuff(name: str) -> bool:
    """Return whether all of a class in an image is one segment, as of floors: what cannot be counted."""
    return name in _STUFF
