"""Label rows of a KITTI folder as targets, and what stands for the CAD of their objects: points in boxes.

As in studies of 6D poses on KITTI: the model of an instance is its cloud in its ground-truth box, in the box's frame
(origin in its centre, x along its length, y along its width, z up), and its diameter the box's diagonal; that of a
class is those of some instances.
"""

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float

from warehouse_sim.dataset.formats.kitti.reader import KittiLabel
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.records import TargetRecord
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.geometry.symmetry import SymmetryGroup

_VISIBLE = {0: 1.0, 1: 0.7, 2: 0.25}
"""Fraction of what lies in the image that is taken for visible, by the level ``occluded``: KITTI gives none, these are
the middles of the bins in which this package writes the levels, and all of what is "fully visible". Unknown (3) counts
as visible."""
_LARGEST_BOX = 65_535.0


def target_record(
    index: int, instance_id: int, label: KittiLabel, T_camera_object: Transform, info: ObjectInfo
) -> TargetRecord:
    """Return a row as a target.

    Args:
        index: Position among the rows of the frame that have a 3D box.
        instance_id: Its number in the frame.
        label: The row.
        T_camera_object: Pose of its box's centre frame in the camera that took the image.
        info: Its own geometry.
    """
    left, top, right, bottom = (float(value) for value in np.clip(label.box_xyxy, -_LARGEST_BOX, _LARGEST_BOX))
    in_image = max(round(right) - round(left) + 1, 0) * max(round(bottom) - round(top) + 1, 0)
    inside = 1.0 - min(max(label.truncated, 0.0), 1.0)
    fraction = _VISIBLE.get(label.occluded, 1.0)
    return TargetRecord(
        gt_index=index,
        obj_id=info.obj_id,
        instance_id=instance_id,
        T_camera_object=T_camera_object,
        visible_fraction=inside * fraction,
        pixels_visible=round(in_image * fraction),
        box_visible_xyxy=(left, top, right, bottom),
        box_amodal_xyxy=(left, top, right, bottom),
        pixels_valid=in_image,
        pixels_all=max(round(in_image / max(inside, 1e-3)), in_image, 1),
        geometry=info,
    )


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
