"""What another driver may draw a little otherwise: images, and the numbers that are counted in their pixels.

The limits were chosen, and stand in docs/trust.md with what was measured.
"""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np

PIXEL_FRACTION = 0.02
"""Images are near where at most that fraction of their pixels is off."""
COLOR_CODES = 8
"""Pixels of colours and masks are off by more codes of 256."""
DEPTH_M, DEPTH_RATIO = 0.005, 0.005
"""Pixels of depth are off by more than so many metres and that ratio."""
DEPTH_STEP = 0.0015
"""Readings of cameras with errors of their own are off by more than so many metres times the square of the distance in
metres, too: two steps of disparity (1/32 px each) of a stereo camera of 447 px and 95 mm, which round another way where
colours differ by a code."""
COUNT, COUNT_RATIO = 3.0, 0.02
"""Numbers of pixels and corners of boxes are near where they differ by at most the larger of both."""
_KITTI_EXACT = (0, 3, *range(8, 15))
"""Fields of a KITTI label that follow from poses: class, angles, size, place."""
_NUMBER = re.compile(r"-?[0-9]+(?:\.[0-9]+)?(?:[eE][-+]?[0-9]+)?")
_MILLIMETRES = 1000.0
_CODES_PER_M = {"depth_2": 256.0, "depth_clean_2": 256.0}
"""KITTI's unit of depth; all others store millimetres."""
_READINGS = ("depth", "depth_2")
"""Folders of what a depth camera has read; ground truth and disparities take no step."""
_SAMPLED_TEXT = ("scene_gt_info.json", "label_2/", "label_2_ids/")
_EXACT_SUFFIXES = (".json", ".txt", ".bin", ".npz", ".md", ".yaml")
_EXACT_FOLDERS = ("models/", "models_eval/", "damaged/")
_RUNS = "scene_gt_coco.json"


def comparison(name: str) -> Callable[[Path, Path], bool] | None:
    """Return how a file that is no image is compared with the one that another driver made; None = it cannot be.

    Args:
        name: Its name within the dataset.
    """
    if name.endswith(_RUNS):
        return None
    if "label_2/" in name:
        return near_labels
    if any(part in name for part in _SAMPLED_TEXT) or name.startswith("yolo/"):
        return near_numbers
    if name.endswith(_EXACT_SUFFIXES) or any(part in name for part in _EXACT_FOLDERS):
        return equal_bytes
    return None


def equal_bytes(path: Path, other: Path) -> bool:
    """Return whether both files are there and the same."""
    return path.is_file() and path.read_bytes() == other.read_bytes()


def is_image(name: str) -> bool:
    """Return whether a file of a dataset is an image, of colours, depth, disparity or a mask."""
    return name.endswith((".png", ".jpg"))


def fraction_off(path: Path, other: Path, step: float = 0.0) -> float:
    """Return which fraction of the pixels of two images is off, 0-1; 1 where they cannot be compared.

    Args:
        path: One image.
        other: The other one.
        step: Of readings of depth, see ``DEPTH_STEP``; ground truth and disparities take none.
    """
    one, two = (cv2.imread(str(item), cv2.IMREAD_UNCHANGED) for item in (path, other))
    if one is None or two is None or one.shape != two.shape or one.dtype != two.dtype:
        return 1.0
    difference = np.abs(one.astype(np.float64) - two.astype(np.float64))
    if one.dtype == np.uint16:
        codes = _CODES_PER_M.get(path.parent.name, _MILLIMETRES)
        metres = one / codes
        limit = np.maximum(DEPTH_M, DEPTH_RATIO * metres)
        if path.parent.name in _READINGS:
            limit = np.maximum(limit, step * metres**2)
        return float(np.mean(difference > limit * codes))
    worst = difference.max(axis=2) if difference.ndim == 3 else difference
    return float(np.mean(worst > COLOR_CODES))


def near_labels(path: Path, other: Path) -> bool:
    """Return whether two KITTI label files say the same of space, and nearly the same of the image."""
    rows, theirs = ([line.split() for line in _text(item).splitlines()] for item in (path, other))
    exact = [[[row[i] for i in _KITTI_EXACT if i < len(row)] for row in found] for found in (rows, theirs)]
    return exact[0] == exact[1] and near_numbers(path, other)


def near_numbers(path: Path, other: Path) -> bool:
    """Return whether two texts differ by no more than a few pixels in each number."""
    one, two = _text(path), _text(other)
    if _NUMBER.sub("0", one) != _NUMBER.sub("0", two):
        return False
    values, theirs = (np.array([float(item) for item in _NUMBER.findall(text)]) for text in (one, two))
    return bool(np.all(np.abs(values - theirs) <= np.maximum(COUNT, COUNT_RATIO * np.abs(values))))


def lasting(record: Any) -> Any:
    """Return a scene record without what is counted in pixels, and the name of the driver."""
    if not isinstance(record, dict):
        return record
    kept = {key: value for key, value in record.items() if key not in ("renderer", "tally", "observations")}
    rows = record.get("observations")
    kept["observations"] = [
        {key: value for key, value in row.items() if key != "targets"} if isinstance(row, dict) else row
        for row in (rows if isinstance(rows, list) else [])
    ]
    return kept


def _text(path: Path) -> str:
    return path.read_bytes().decode("utf-8", "replace") if path.is_file() else "(missing)"
