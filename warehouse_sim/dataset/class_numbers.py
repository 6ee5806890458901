"""Class names as numbers, for the formats whose points bear a number: the same in every scene of every dataset."""

import zlib
from collections.abc import Mapping

import numpy as np
from jaxtyping import Int32

from warehouse_sim.schema import ObjectAnnotation, SceneSpec

_NAMES = (
    "amr",
    "big_bag",
    "bin",
    "bollard",
    "cart",
    "carton",
    "ceiling",
    "clutter",
    "column",
    "cone",
    "conveyor",
    "corner_post",
    "dock",
    "door",
    "drum",
    "fire_equipment",
    "floor",
    "forklift",
    "gitterbox",
    "guard",
    "ibc",
    "long_goods",
    "luminaire",
    "marking",
    "octabin",
    "pallet",
    "pallet_jack",
    "person",
    "rack",
    "roll_container",
    "sack",
    "sign",
    "slip_sheet",
    "tote",
    "trailer",
    "tugger",
    "wall",
    "wrap",
)
"""In the order of their numbers, from 1; a new class goes to the end, so that datasets keep theirs."""
CLASS_NUMBERS: Mapping[str, int] = {name: number for number, name in enumerate(_NAMES, start=1)}
"""Classes of the package's own objects; 0 is no class."""
_FIRST_OF_OTHERS = 1000
_MOST_OTHERS = 2**30


def class_number(name: str) -> int:
    """Return the number of a class: that of ``CLASS_NUMBERS``, or one that follows from the name (CRC-32) alone."""
    return CLASS_NUMBERS.get(name) or _FIRST_OF_OTHERS + zlib.crc32(name.encode("utf-8")) % _MOST_OTHERS


def classes_of(scene: SceneSpec, annotations: tuple[ObjectAnnotation, ...] = ()) -> dict[int, str]:
    """Return class names by instance id of all that stands in a scene, or else that a label names."""
    named = {item.instance_id: item.class_name for item in annotations}
    return named | {item.instance_id: scene.model_of(item).class_name for item in scene.instances}


def class_labels(instance_ids: Int32[np.ndarray, " n"], classes: Mapping[int, str]) -> Int32[np.ndarray, " n"]:
    """Return the class number of each instance id; 0 where the id is 0 or nothing bears it."""
    if not instance_ids.size:
        return np.zeros(0, np.int32)
    # One look-up for all points: ids are small numbers.
    table = np.zeros(int(instance_ids.max()) + 1, np.int32)
    for instance_id, name in classes.items():
        if 0 < instance_id < len(table):
            table[instance_id] = class_number(name)
    labels: Int32[np.ndarray, " n"] = table[instance_ids]
    return labels
