"""The images of a split on their canvas, with the boxes of their targets: read once, kept in a cache, mapped."""

from collections.abc import Callable
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Protocol

import numpy as np
from jaxtyping import Float, Float32, UInt16

from warehouse_sim.dataset.reader import DatasetReader, ImageRecord, TargetRecord
from warehouse_sim.dataset.records import ImagePixels
from warehouse_sim.errors import DatasetError
from warehouse_sim.estimators.images.encoding import CANONICAL_FOCAL_PX
from warehouse_sim.estimators.images.faces import MaskReader, face_labels
from warehouse_sim.estimators.images.letterbox import Letterbox
from warehouse_sim.estimators.images.settings import DepthSource, ImageConfig
from warehouse_sim.estimators.lidar.projection import read_sweep, sparse_depth, sweep_points
from warehouse_sim.estimators.lidar.upsample import upsample
from warehouse_sim.learning.samples.array_store import Arrays
from warehouse_sim.learning.samples.split import load_rows, split_images

SMALL_ARRAYS = ("labels", "size_wh", "number")
"""Of the arrays of images, those that are no images."""
MOST_LABELS = 128
"""Of an image with more, the largest are kept."""
LABEL = ("left", "top", "right", "bottom", "obj_id", "visible_fraction", "height_px", "gt_index")
"""Columns of a label: edges on the canvas (px), object, what is seen of it, height in the image itself (px)."""


class ImageReader(ImagePixels, MaskReader, Protocol):
    """What gives the pixels of an image: a dataset's reader, or an observation that no file holds."""

    @property
    def has_depth(self) -> bool:
        """Whether there are depth images."""


def image_rows(reader: DatasetReader | ImageReader, image: ImageRecord, config: ImageConfig) -> Arrays:
    """Return one row of each array.

    ``labels`` (1 m 8) has a row a target as ``LABEL`` names it, NaN where there is none, ``size_wh`` the image's own
    size, ``rgb`` (1 h w 3) uint8 and ``depth`` (1 h w) uint16, canonical millimetres, what the network reads.
    """
    camera = image.camera
    box = Letterbox.fit((camera.width, camera.height), config.input_wh)
    faces = face_labels(reader, image, box) if config.faces else np.zeros((0, len(LABEL)))
    rows: Arrays = {
        "labels": image_labels(image.targets, box, faces)[None],
        "size_wh": np.array([box.source_wh], dtype=np.int32),
        "number": np.array([[image.scene_id, image.image_id]], dtype=np.int32),
    }
    if "rgb" in config.reads:
        rows["rgb"] = box.smooth(reader.rgb(image))[None]
    if "depth" in config.reads:
        depth = read_depth(reader, image, config.depth_source)
        rows["depth"] = canonical_mm(box.picked(depth), box.focal_px(camera))[None]
    return rows


def image_labels(
    targets: tuple[TargetRecord, ...], box: Letterbox, faces: Float[np.ndarray, "f 8"]
) -> Float32[np.ndarray, "m 8"]:
    """Return the labels of an image's visible targets, the largest first, then faces; rows of NaN fill the rest."""
    labels = np.full((MOST_LABELS, len(LABEL)), np.nan, dtype=np.float32)
    seen = [target for target in targets if target.pixels_visible > 0]
    seen.sort(key=lambda target: -target.pixels_visible)
    largest = np.argsort(faces[:, 0] - faces[:, 2], kind="stable")[: MOST_LABELS // 2]
    seen = seen[: MOST_LABELS - len(largest)]
    labels[len(seen) : len(seen) + len(largest)] = faces[largest]
    for row, target in zip(labels, seen, strict=False):
        left, top, right, bottom = target.box_visible_xyxy
        # Inclusive corners of pixel centres become edges.
        row[:4] = box.onto_canvas(np.array([[left, top, right + 1.0, bottom + 1.0]]))[0]
        row[4:] = target.obj_id, target.visible_fraction, bottom - top + 1.0, target.gt_index
    return labels


def canonical_mm(depth: Float32[np.ndarray, "h w"], focal_px: float) -> UInt16[np.ndarray, "h w"]:
    """Return canonical depth in millimetres; beyond 65 m it is 65 m."""
    scaled = depth * np.float32(1000.0 * CANONICAL_FOCAL_PX / focal_px)
    return np.clip(np.rint(scaled), 0, 65_000).astype(np.uint16)


def read_depth(
    reader: DatasetReader | ImageReader, image: ImageRecord, source: DepthSource
) -> Float32[np.ndarray, "h w"]:
    """Return the depth of an image (m), 0 where there is none.

    Raises:
        DatasetError: The dataset holds none, or no sweeps.
    """
    if source == "lidar":
        if not isinstance(reader, DatasetReader):
            raise DatasetError("a stream has no sweeps: take the depth camera's, or train on a dataset")
        return upsample(sparse_depth(image.camera, sweep_points(read_sweep(reader, image))).depth)
    if isinstance(reader, DatasetReader) and not reader.has_depth:
        raise DatasetError(f"{reader.root}: holds no depth images; take a detector of colour")
    return reader.depth(image)


_FORMAT = 4
"""To be raised when the arrays change."""


def load_images(
    reader: DatasetReader,
    split: str,
    config: ImageConfig,
    workers: int,
    cache: Path | None,
    progress: Callable[[float], None] | None = None,
) -> list[Arrays]:
    """Return the arrays of ``image_rows`` for all images of a split, those of one canvas together.

    Arguments are those of ``load_rows``; ``config`` says what is read.

    Raises:
        TrainingError: No such split, or the cache cannot be written.
        DatasetError: Depth is requested, and there is none.
    """
    groups: dict[tuple[int, int], list[ImageRecord]] = {}
    for image in split_images(reader, split):
        groups.setdefault((image.camera.width, image.camera.height), []).append(image)
    found = list[Arrays | None]()
    for size_wh, images in groups.items():
        settings = [_FORMAT, split, size_wh, asdict(config)]
        read = partial(image_rows, reader, config=config)
        found.append(load_rows(reader, split, images, read, settings, "images", workers, cache, progress))
    return [arrays for arrays in found if arrays is not None]
