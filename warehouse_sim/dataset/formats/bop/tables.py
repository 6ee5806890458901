"""Rows of the BOP tables of one image, camera, poses, visibility, and the same as COCO: how they are made and read."""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float32

from warehouse_sim.dataset.files.json_file import read_table
from warehouse_sim.dataset.files.plain import (
    FRACTIONS,
    PLACES,
    WHOLE,
    Span,
    is_rigid,
    lens_row,
    read_lens,
    take,
    take_if_given,
    take_numbers,
)
from warehouse_sim.dataset.formats.bop import BopSceneLayout
from warehouse_sim.dataset.formats.observation_files import VISIBLE_ENOUGH, LabelledTarget, box_xywh
from warehouse_sim.dataset.records import ImageRecord, TargetRecord
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, invert, make_transform
from warehouse_sim.schema import ObjectAnnotation, Observation

DEPTH_SCALES = Span(1e-3, 1e3)
"""Millimetres a step."""
_PIXELS = Span(-1e6, 1e6)
"""Intrinsics and corners of boxes, which may leave the image (px)."""
_PLACES_MM = Span(1000.0 * PLACES.low, 1000.0 * PLACES.high)


def read_bop_scene(layout: BopSceneLayout, split: str, scene_id: int, size_wh: tuple[int, int]) -> list[ImageRecord]:
    """Read the tables of one BOP scene.

    Args:
        layout: The scene's paths.
        split: The split it belongs to.
        scene_id: Its number.
        size_wh: Width and height of its images in pixels.

    Raises:
        DatasetError: A table is missing, malformed, or disagrees with another one.
    """
    cameras, poses, infos = (read_table(layout.table(name)) for name in ("camera", "gt", "gt_info"))
    if not set(cameras) == set(poses) == set(infos):
        raise DatasetError(f"{layout.root}: scene_camera, scene_gt and scene_gt_info do not list the same images")
    return [
        read_image(
            split,
            (scene_id, key),
            size_wh,
            BopRows(
                (cameras[key], f"{layout.table('camera')}: {key}"),
                (poses[key], f"{layout.table('gt')}: {key}"),
                (infos[key], f"{layout.table('gt_info')}: {key}"),
            ),
        )
        for key in cameras
    ]


class BopRows(NamedTuple):
    """What BOP says of one image: the rows of three tables, each with the place that errors name."""

    camera: tuple[Any, str]
    poses: tuple[Any, str]
    infos: tuple[Any, str]


def read_image(split: str, numbers: tuple[int, int], size_wh: tuple[int, int], rows: BopRows) -> ImageRecord:
    """Read the rows of one image.

    Args:
        split: The split it belongs to.
        numbers: Scene and image.
        size_wh: Width and height of the image in pixels.
        rows: Of the tables camera, gt and gt_info.

    Raises:
        DatasetError: A row is malformed, or disagrees with another one.
    """
    (camera, camera_where), (poses, where), (infos, _) = rows
    if not isinstance(poses, list) or not isinstance(infos, list) or len(poses) != len(infos):
        raise DatasetError(f"{where}: scene_gt and scene_gt_info do not list the same number of objects")
    return ImageRecord(
        split=split,
        scene_id=numbers[0],
        image_id=numbers[1],
        camera=read_camera(camera, size_wh, camera_where),
        T_world_camera=invert(read_pose(camera, "cam_R_w2c", "cam_t_w2c", camera_where)),
        depth_scale=take(camera, "depth_scale", float, camera_where, DEPTH_SCALES),
        targets=tuple(
            _read_target(i, pose, info, f"{where}[{i}]")
            for i, (pose, info) in enumerate(zip(poses, infos, strict=True))
        ),
    )


def _read_target(index: int, pose: Any, info: Any, where: str) -> TargetRecord:
    return TargetRecord(
        gt_index=index,
        obj_id=take(pose, "obj_id", int, where, WHOLE),
        instance_id=take_if_given(info, "instance_id", int, where, WHOLE) or 0,
        T_camera_object=read_pose(pose, "cam_R_m2c", "cam_t_m2c", where),
        visible_fraction=take(info, "visib_fract", float, where, FRACTIONS),
        pixels_visible=take(info, "px_count_visib", int, where, WHOLE),
        box_visible_xyxy=read_box(info, "bbox_visib", where),
        box_amodal_xyxy=read_box(info, "bbox_obj", where),
        pixels_valid=take(info, "px_count_valid", int, where, WHOLE),
        pixels_all=take(info, "px_count_all", int, where, WHOLE),
    )


def read_pose(data: Any, rotation: str, translation: str, where: str) -> Transform:
    """Read a pose whose translation is in millimetres.

    Raises:
        DatasetError: It is missing, or no rigid motion.
    """
    R, t_mm = take_numbers(data, rotation, 9, where), take_numbers(data, translation, 3, where, _PLACES_MM)
    T = make_transform(R.reshape(3, 3), t_mm / 1000.0)
    if not is_rigid(T):
        raise DatasetError(f"{where}: {rotation} is not a rotation: {R.tolist()}")
    return T


def read_camera(data: Any, size_wh: tuple[int, int], where: str) -> PinholeCamera:
    """Read a row of scene_camera.json.

    Raises:
        DatasetError: cam_K or cam_distortion are those of no camera.
    """
    fx, skew, cx, _, fy, cy, *last = take_numbers(data, "cam_K", 9, where, _PIXELS)
    if skew != 0.0 or last != [0.0, 0.0, 1.0]:
        raise DatasetError(f"{where}: cam_K must be a pinhole camera without skew")
    distortion = read_lens(data, where, "cam_")
    try:
        camera = PinholeCamera(*size_wh, float(fx), float(fy), float(cx), float(cy), distortion)
        camera.require_clear_lens()
    except ValueError as problem:
        raise DatasetError(f"{where}: cam_K is no camera ({problem})") from problem
    return camera


def read_box(data: Any, key: str, where: str) -> tuple[float, float, float, float]:
    """Read a box as its inclusive corners (px)."""
    left, top, width, height = (float(value) for value in take_numbers(data, key, 4, where, _PIXELS))
    # BOP's width is the difference of inclusive corners, without one more.
    return left, top, left + width, top + height


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
