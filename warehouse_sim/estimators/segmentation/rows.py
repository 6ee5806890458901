"""The targets of one image as rows of arrays: crops about their boxes, masks, key points."""

import numpy as np
from jaxtyping import Float

from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.reader import DatasetReader, ImageRecord, TargetRecord
from warehouse_sim.errors import DatasetError
from warehouse_sim.estimators.segmentation.face_points import POINTS, face_points
from warehouse_sim.estimators.segmentation.settings import BoxCropConfig
from warehouse_sim.estimators.segmentation.window import Edges, Window
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.learning.array_store import Arrays

LEAST_PIXELS = 24
"""Visible pixels without which nothing is stored of a target."""


def target_rows(reader: DatasetReader, image: ImageRecord, config: BoxCropConfig) -> Arrays | None:
    """Return a row for each target that shows enough; None where none does.

    ``mask`` (k h w) uint8 and, as they are read, ``rgb`` (k h w 3) uint8 and ``depth`` (k h w) uint16 (mm) are stored
    crops; ``points`` (k p 3) key points on them (px) with their flag; ``facts`` (k 5): obj_id, visible fraction, height
    in the image (px), width of the box over the focal length, position among the labels.
    """
    targets = [item for item in image.targets if item.pixels_visible >= LEAST_PIXELS]
    if not targets:
        return None
    rgb = reader.rgb(image) if "rgb" in config.reads else None
    if "depth" in config.reads and not reader.has_depth:
        raise DatasetError(f"{reader.root}: holds no depth images; take a segmenter of colour")
    depth_mm = None
    if reader.has_depth:
        depth_mm = np.clip(np.rint(reader.depth(image) * 1000.0), 0, 65_000).astype(np.uint16)
    columns: dict[str, list[np.ndarray]] = {}
    for target in targets:
        box = target_edges(target)
        window = Window.about(box, config.stored_margin, config.stored_wh)
        row = {
            "mask": window.picked(reader.mask_visible(image, target.gt_index).astype(np.uint8)),
            "points": _points(target, target.info(reader.objects), image.camera, window),
            "facts": _facts(target, box, image.camera),
        }
        if rgb is not None:
            row["rgb"] = window.smooth(rgb)
        if depth_mm is not None and "depth" in config.reads:
            row["depth"] = window.picked(depth_mm)
        for name, value in row.items():
            columns.setdefault(name, []).append(value)
    return {name: np.stack(values) for name, values in columns.items()}


def target_edges(target: TargetRecord) -> Edges:
    """Return the box of edges of a target's visible pixels."""
    left, top, right, bottom = target.box_visible_xyxy
    return left, top, right + 1.0, bottom + 1.0


def _facts(target: TargetRecord, box: Edges, camera: PinholeCamera) -> Float[np.ndarray, " 5"]:
    width_rad = (box[2] - box[0]) / camera.fx
    values = [target.obj_id, target.visible_fraction, box[3] - box[1], width_rad, target.gt_index]
    return np.array(values, dtype=np.float32)


def _points(target: TargetRecord, info: ObjectInfo, camera: PinholeCamera, window: Window) -> np.ndarray:
    """Return key points on the crop with 1 where they are in front of the camera, 0 where there are none."""
    points = np.zeros((POINTS, 3), dtype=np.float32)
    face = face_points(info.size, info.pockets, target.T_camera_object) if target.has_pose else None
    if face is not None:
        points_camera, known = face
        ahead = known & (points_camera[:, 2] > 0.05)
        points[ahead, :2] = window.to_crop(camera.project(points_camera[ahead])) if ahead.any() else 0
        points[ahead, 2] = 1.0
    return points
