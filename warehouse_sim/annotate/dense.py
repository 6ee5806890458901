"""Exact data of every pixel on request: where it lies in the box of its target, and which class it shows."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float32, Int32

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import invert, transform_points
from warehouse_sim.schema import ObjectAnnotation, RenderBuffers, SceneSpec
from warehouse_sim.schema.classes import class_number


def object_coordinates(
    camera: PinholeCamera, buffers: RenderBuffers, labels: Sequence[ObjectAnnotation]
) -> Float32[np.ndarray, "h w 3"]:
    """Return where each visible pixel of a target lies in its object's box: 0 to 1 along each edge, NaN elsewhere.

    These are normalised object coordinates (NOCS, Wang et al., CVPR 2019) with each axis scaled for itself. What is
    worn or overhangs may leave its nominal box by a little.

    Args:
        camera: With which intrinsics ``buffers`` were rendered.
        buffers: The clean rendering.
        labels: The targets.
    """
    found = np.full((*buffers.depth.shape, 3), np.nan, np.float32)
    points = camera.unproject(buffers.depth)
    for label in labels:
        if label.box_visible_xyxy is None:
            continue
        left, top, right, bottom = label.box_visible_xyxy
        window = slice(top, bottom + 1), slice(left, right + 1)
        shown = buffers.instance_mask[window] == label.instance_id
        in_object = transform_points(invert(label.T_camera_object), points[window][shown])
        found[window][shown] = in_object / label.size + 0.5
    return found


def class_numbers(scene: SceneSpec, instance_mask: Int32[np.ndarray, "h w"]) -> Int32[np.ndarray, "h w"]:
    """Return the number of the class (``schema.classes``) of the object that each pixel shows, 0 = none."""
    number_of = np.zeros(max((item.instance_id for item in scene.instances), default=0) + 1, np.int32)
    for item in scene.instances:
        number_of[item.instance_id] = class_number(scene.model_of(item).class_name)
    return number_of[instance_mask]
