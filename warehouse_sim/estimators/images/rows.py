"""One image of a dataset as rows of arrays: scaled onto its canvas, with the boxes of its targets."""

from collections.abc import Callable

import numpy as np
from jaxtyping import Float32, UInt16

from warehouse_sim.dataset.reader import DatasetReader, ImageRecord, TargetRecord
from warehouse_sim.errors import DatasetError
from warehouse_sim.estimators.images.encoding import CANONICAL_FOCAL_PX
from warehouse_sim.estimators.images.letterbox import Letterbox
from warehouse_sim.estimators.images.settings import DepthSource, ImageConfig
from warehouse_sim.estimators.lidar.projection import sparse_depth
from warehouse_sim.estimators.lidar.upsample import upsample
from warehouse_sim.geometry.pose import transform_points
from warehouse_sim.learning.array_store import Arrays

MOST_LABELS = 128
"""Of an image with more, the largest are kept."""
LABEL = ("left", "top", "right", "bottom", "obj_id", "visible_fraction", "height_px", "gt_index")
"""Columns of a label: edges on the canvas (px), object, what is seen of it, height in the image itself (px)."""
DepthReader = Callable[[DatasetReader, ImageRecord], Float32[np.ndarray, "h w"]]


def image_rows(reader: DatasetReader, image: ImageRecord, config: ImageConfig) -> Arrays:
    """Return one row of each array.

    ``labels`` (1 m 8) has a row a target as ``LABEL`` names it, NaN where there is none, ``size_wh`` the image's own
    size, ``rgb`` (1 h w 3) uint8 and ``depth`` (1 h w) uint16, canonical millimetres, what the network reads.
    """
    camera = image.camera
    box = Letterbox.fit((camera.width, camera.height), config.input_wh)
    rows: Arrays = {
        "labels": image_labels(image.targets, box)[None],
        "size_wh": np.array([box.source_wh], dtype=np.int32),
        "number": np.array([[image.scene_id, image.image_id]], dtype=np.int32),
    }
    if "rgb" in config.reads:
        rows["rgb"] = box.smooth(reader.rgb(image))[None]
    if "depth" in config.reads:
        depth = depth_reader(config.depth_source)(reader, image)
        rows["depth"] = canonical_mm(box.picked(depth), box.focal_px(camera))[None]
    return rows


def image_labels(targets: tuple[TargetRecord, ...], box: Letterbox) -> Float32[np.ndarray, "m 8"]:
    """Return the labels of an image's visible targets, the largest first; rows of NaN fill the rest."""
    labels = np.full((MOST_LABELS, len(LABEL)), np.nan, dtype=np.float32)
    seen = [target for target in targets if target.pixels_visible > 0]
    seen.sort(key=lambda target: -target.pixels_visible)
    for row, target in zip(labels, seen[:MOST_LABELS], strict=False):
        left, top, right, bottom = target.box_visible_xyxy
        # Inclusive corners of pixel centres become edges.
        row[:4] = box.onto_canvas(np.array([[left, top, right + 1.0, bottom + 1.0]]))[0]
        row[4:] = target.obj_id, target.visible_fraction, bottom - top + 1.0, target.gt_index
    return labels


def canonical_mm(depth: Float32[np.ndarray, "h w"], focal_px: float) -> UInt16[np.ndarray, "h w"]:
    """Return canonical depth in millimetres; beyond 65 m it is 65 m."""
    scaled = depth * np.float32(1000.0 * CANONICAL_FOCAL_PX / focal_px)
    return np.clip(np.rint(scaled), 0, 65_000).astype(np.uint16)


def depth_reader(source: DepthSource) -> DepthReader:
    """Return what reads the depth of an image."""
    return _camera_depth if source == "camera" else _lidar_depth


def _camera_depth(reader: DatasetReader, image: ImageRecord) -> Float32[np.ndarray, "h w"]:
    if not reader.has_depth:
        raise DatasetError(f"{reader.root}: holds no depth images; take a detector of colour")
    return reader.depth(image)


def _lidar_depth(reader: DatasetReader, image: ImageRecord) -> Float32[np.ndarray, "h w"]:
    mounted = reader.sweep(image)
    if mounted is None:
        raise DatasetError(f"{reader.root}: holds no sweeps; generate it with a LiDAR and the format kitti")
    points = transform_points(mounted.T_camera_sensor, mounted.reading.points.astype(float))
    return upsample(sparse_depth(image.camera, points).depth)
