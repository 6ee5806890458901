"""A few small pictures of a dataset: made of the images as these are written, put on one sheet at the end."""

import math
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from jaxtyping import UInt8

from warehouse_sim.dataset.files.image_io import decode_any_rgb
from warehouse_sim.output import make_folder, write_bytes

SHEET = "thumbnails.jpg"
_COUNT, _COLUMNS = 12, 4
_WIDTH, _GAP = 320, 4
_QUALITY = 90


def shown_observations(scenes: int, observations_per_scene: int) -> list[tuple[int, int]]:
    """Return scene and observation of those that have a thumbnail: evenly spread over the dataset, 12 at most."""
    every = scenes * observations_per_scene
    count = min(every, _COUNT)
    return [divmod(index * every // count, observations_per_scene) for index in range(count)]


def write_thumbnail(folder: Path, rgb: UInt8[np.ndarray, "h w 3"], scene: int, observation: int) -> None:
    """Store an image 320 pixels wide."""
    height, width = rgb.shape[:2]
    size = _WIDTH, max(round(height * _WIDTH / width), 1)
    small = cv2.resize(rgb, size, interpolation=cv2.INTER_AREA if width > _WIDTH else cv2.INTER_LINEAR)
    make_folder(folder)
    write_bytes(thumbnail_file(folder, scene, observation), encode_jpeg(small))


def thumbnail_file(folder: Path, scene: int, observation: int) -> Path:
    """Return the file of an observation's thumbnail."""
    return folder / f"{scene:06d}_{observation:06d}.jpg"


def write_sheet(folder: Path, shown: Sequence[tuple[int, int]]) -> bool:
    """Put the thumbnails in ``folder`` on one sheet, row by row; return whether there is any.

    Args:
        folder: Where they are.
        shown: Scene and observation of each, in order; those that have no file are left out.
    """
    files = [thumbnail_file(folder, *item) for item in shown]
    images = [decode_any_rgb(path) for path in files if path.is_file()]
    if images:
        write_bytes(folder / SHEET, encode_jpeg(tiled(images, _COLUMNS)))
    return bool(images)


def tiled(images: Sequence[UInt8[np.ndarray, "_ _ 3"]], columns: int) -> UInt8[np.ndarray, "h w 3"]:
    """Return images in rows on a dark ground; each has the place of the largest."""
    height = max(image.shape[0] for image in images) + _GAP
    width = max(image.shape[1] for image in images) + _GAP
    columns = min(columns, len(images))
    rows = math.ceil(len(images) / columns)
    sheet = np.full((rows * height + _GAP, columns * width + _GAP, 3), 18, dtype=np.uint8)
    for number, image in enumerate(images):
        top, left = _GAP + number // columns * height, _GAP + number % columns * width
        sheet[top : top + image.shape[0], left : left + image.shape[1]] = image
    return sheet


def encode_jpeg(rgb: UInt8[np.ndarray, "h w 3"]) -> bytes:
    """Return the JPEG of an RGB image."""
    settings = [cv2.IMWRITE_JPEG_QUALITY, _QUALITY]
    return bytes(cv2.imencode(".jpg", cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR), settings)[1].tobytes())
