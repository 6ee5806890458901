"""A label row of a third-party KITTI folder as a target, whose 2D box stands for its masks."""

import numpy as np
from jaxtyping import Bool

from warehouse_sim.dataset.formats.kitti.label import KittiLabel
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.records import TargetRecord
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform

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


def box_pixels(box_xyxy: tuple[float, float, float, float], camera: PinholeCamera) -> Bool[np.ndarray, "h w"]:
    """Return the pixels whose centres lie in a box, as far as it lies in the image."""
    mask = np.zeros((camera.height, camera.width), dtype=bool)
    left, top, right, bottom = np.rint(np.clip(box_xyxy, -1, _LARGEST_BOX)).astype(int)
    mask[max(top, 0) : max(bottom + 1, 0), max(left, 0) : max(right + 1, 0)] = True
    return mask
