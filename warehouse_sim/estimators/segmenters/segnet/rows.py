"""The boxes of a split's targets with what is around them, masks and key points: read once, kept in a cache, mapped."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path

import numpy as np
from jaxtyping import Float

from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.reader import DatasetReader, ImageRecord, TargetRecord
from warehouse_sim.errors import DatasetError, TrainingError
from warehouse_sim.estimators.images.rows import ImageReader
from warehouse_sim.estimators.segmenters.segnet.keypoints import POINTS, face_points
from warehouse_sim.estimators.segmenters.segnet.settings import BoxCropConfig, SegmenterConfig
from warehouse_sim.estimators.segmenters.segnet.task import BoxRows
from warehouse_sim.estimators.segmenters.segnet.window import Edges, Window
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.learning.samples.array_store import Arrays
from warehouse_sim.learning.samples.split import load_rows, reports_reading, split_images
from warehouse_sim.learning.settings import Progress

LEAST_PIXELS = 24
"""Visible pixels without which nothing is stored of a target."""


def target_rows(reader: DatasetReader | ImageReader, image: ImageRecord, config: BoxCropConfig) -> Arrays | None:
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
        raise DatasetError(
            f"{getattr(reader, 'root', 'the stream')}: holds no depth images; take a segmenter of colour"
        )
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


_FORMAT = 1
"""To be raised when the arrays change."""


def prepare(
    readers: Sequence[DatasetReader],
    crop: BoxCropConfig,
    config: SegmenterConfig,
    cache: Path | None,
    progress: Progress | None,
) -> dict[str, BoxRows]:
    """Cut the boxes of all targets of train and val out of the images, and return them by split.

    A stream that ``config`` names takes the place of train.

    Raises:
        DatasetError: A dataset lacks what is read.
        TrainingError: A split shows too little.
    """
    rows = dict[str, BoxRows]()
    for split in ("val",) if config.stream.recipe else ("train", "val"):
        parts, chosen = list[Arrays](), list[np.ndarray]()
        for reader in readers:
            arrays = load_boxes(reader, split, crop, config.workers, cache, reports_reading(progress, split, reader))
            if arrays is not None:
                parts.append(arrays)
                chosen.append(wanted_rows(arrays["facts"], reader.objects, config))
        rows[split] = BoxRows(parts, chosen)
        if not len(rows[split]):
            folders = ", ".join(str(reader.root) for reader in readers)
            raise TrainingError(f"{folders}: the split {split!r} shows no target well enough; generate more scenes")
    return rows


def load_boxes(
    reader: DatasetReader,
    split: str,
    crop: BoxCropConfig,
    workers: int,
    cache: Path | None,
    progress: Callable[[float], None] | None = None,
) -> Arrays | None:
    """Return the arrays of ``target_rows`` for all targets of a split; arguments are those of ``load_rows``.

    Raises:
        TrainingError: No such split, or the cache cannot be written.
    """
    settings, images = [_FORMAT, split, asdict(crop)], split_images(reader, split)
    read = partial(target_rows, reader, config=crop)
    return load_rows(reader, split, images, read, settings, "boxes", workers, cache, progress, f"boxes-{split}")


def wanted_rows(facts: np.ndarray, objects: Mapping[int, ObjectInfo], config: SegmenterConfig) -> np.ndarray:
    """Return the rows that are trained on."""
    requested = (facts[:, 1] >= config.visible) & (facts[:, 2] >= config.height_px)
    if config.classes:
        known = [i for i, info in objects.items() if {info.class_name, info.name} & set(config.classes)]
        requested &= np.isin(facts[:, 0].astype(int), known)
    return np.flatnonzero(requested)
