"""What stands for the CAD of KITTI's objects: the points in an instance's box, and of a class those of some instances.

As in studies of 6D poses on KITTI: the model of an instance is its cloud in its ground-truth box, in the box's frame
(origin in its centre, x along its length, y along its width, z up), and its diameter the box's diagonal.
"""

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float

from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.records import TargetRecord
from warehouse_sim.geometry.symmetry import SymmetryGroup

_KITTI = ("Car", "Van", "Truck", "Pedestrian", "Person_sitting", "Cyclist", "Tram", "Misc")
"""KITTI's own classes have the same number in every folder, from 1."""
_MOST_CLOUDS = 200
"""Instances whose clouds make the cloud of a class."""

Cloud = Float[np.ndarray, "n 3"]


def class_numbers(names: Iterable[str]) -> dict[str, int]:
    """Return a number for each class: those of KITTI have their own, all others follow by name."""
    others = sorted(set(names) - set(_KITTI))
    return {name: number for number, name in enumerate((*_KITTI, *others), start=1)}


def box_info(
    obj_id: int, name: str, size: Float[np.ndarray, " 3"], root: Path, read_cloud: Callable[[], Cloud]
) -> ObjectInfo:
    """Return an object that is a cloud in a box.

    Args:
        obj_id: Number of its class.
        name: Of its class.
        size: Length, width and height of the box (m).
        root: Folder of the dataset.
        read_cloud: Reads its points (m, in the box's frame).
    """
    return ObjectInfo(
        obj_id=obj_id,
        name=name,
        class_name=name,
        size=size,
        diameter=float(np.linalg.norm(size)),
        symmetry=SymmetryGroup.trivial(),
        pockets=(),
        root=root,
        read_cloud=read_cloud,
    )


def class_infos(targets: Sequence[TargetRecord], root: Path) -> dict[int, ObjectInfo]:
    """Return an object for each class: the mean box, and the clouds of up to 200 instances, each scaled to that box.

    Args:
        targets: Labelled instances, each with its own geometry; those of training come first.
        root: Folder of the dataset.
    """
    found: dict[int, list[ObjectInfo]] = {}
    for target in targets:
        if target.geometry is not None:
            found.setdefault(target.obj_id, []).append(target.geometry)
    return {obj_id: _class_info(found[obj_id], root) for obj_id in sorted(found)}


def _class_info(instances: Sequence[ObjectInfo], root: Path) -> ObjectInfo:
    size = np.mean([item.size for item in instances], axis=0)
    few = instances[:: max(1, -(-len(instances) // _MOST_CLOUDS))]

    def read_cloud() -> Cloud:
        return np.concatenate([item.model_points() * (size / item.size) for item in few])

    return box_info(instances[0].obj_id, instances[0].name, size, root, read_cloud)
