"""Rows of the BOP tables of one image: camera, poses, visibility, and the same as COCO."""

from typing import Any

import numpy as np
from jaxtyping import Float32

from warehouse_sim.dataset.files.plain import lens_row
from warehouse_sim.dataset.formats.observation_files import VISIBLE_ENOUGH, LabelledTarget, box_xywh
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import invert
from warehouse_sim.schema import ObjectAnnotation, Observation

DEPTH_SCALE = 1.0
"""Millimetres a step of the depth images: 65.5 m of range, where BOP's usual 0.1 ends at 6.55 m."""


def camera_row(observation: Observation) -> dict[str, Any]:
    """Return an entry of scene_camera.json; translations in millimetres."""
    T_camera_world = invert(observation.T_world_camera)
    return {
        "cam_K": observation.camera.K.ravel().tolist(),
        **lens_row(observation.camera, "cam_"),
        "depth_scale": DEPTH_SCALE,
        "cam_R_w2c": T_camera_world[:3, :3].ravel().tolist(),
        "cam_t_w2c": (T_camera_world[:3, 3] * 1000.0).tolist(),
    }


def pose_row(annotation: ObjectAnnotation) -> dict[str, Any]:
    """Return an entry of scene_gt.json; the translation in millimetres."""
    return {
        "obj_id": annotation.obj_id,
        "cam_R_m2c": annotation.T_camera_object[:3, :3].ravel().tolist(),
        "cam_t_m2c": (annotation.T_camera_object[:3, 3] * 1000.0).tolist(),
    }


def visibility_row(target: LabelledTarget, depth: Float32[np.ndarray, "h w"]) -> dict[str, Any]:
    """Return an entry of scene_gt_info.json.

    Counts are those of bop_toolkit's calc_gt_info: px_count_all over a canvas of three images each way, px_count_valid
    over the amodal mask in the image, occluded or not, where the depth image has a reading. ``instance_id`` is our own
    addition; it leads to the scene record.
    """
    annotation = target.annotation
    return {
        "bbox_obj": box_xywh(annotation.box_amodal_xyxy, extra=0),
        "bbox_visib": box_xywh(target.box_visible_xyxy, extra=0),
        "px_count_all": annotation.pixels_all,
        "px_count_valid": int(np.count_nonzero(target.mask & (depth > 0))),
        "px_count_visib": annotation.pixels_visible,
        "visib_fract": annotation.visible_fraction,
        "instance_id": annotation.instance_id,
    }


def coco_image(image_id: int, camera: PinholeCamera) -> dict[str, Any]:
    """Return an image of scene_gt_coco.json."""
    return {"id": image_id, "file_name": f"rgb/{image_id:06d}.png", "width": camera.width, "height": camera.height}


def coco_annotation(number: int, image_id: int, target: LabelledTarget) -> dict[str, Any]:
    """Return an annotation of scene_gt_coco.json: amodal box (COCO's width, one more than BOP's), visible mask.

    Args:
        number: Annotation id, >= 1: COCO's evaluation reads 0 as "unmatched".
        image_id: Image it belongs to.
        target: The target and its masks.
    """
    annotation = target.annotation
    return {
        "id": number,
        "image_id": image_id,
        "category_id": annotation.obj_id,
        "iscrowd": 0,
        "ignore": annotation.visible_fraction < VISIBLE_ENOUGH,
        "area": annotation.pixels_visible,
        "bbox": box_xywh(annotation.box_amodal_xyxy, extra=1),
        "segmentation": target.runs_visible,
        "width": target.mask_visible.shape[1],
        "height": target.mask_visible.shape[0],
    }
