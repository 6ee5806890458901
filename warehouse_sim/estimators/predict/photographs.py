"""Find objects in photographs: images of any camera, without depth, calibration or labels."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from jaxtyping import UInt8

from warehouse_sim.dataset.files.run_lengths import compressed, run_lengths
from warehouse_sim.errors import InputError
from warehouse_sim.estimators.api import FrontEnd
from warehouse_sim.estimators.detections import found_object, open_stages
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.pipeline import passed
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.learning.settings import Progress
from warehouse_sim.schema.classes import numbered

_SUFFIXES = (".jpg", ".jpeg", ".png", ".bmp", ".webp")


def find_in_photographs(
    names: str, folder: Path, progress: Progress | None = None, min_score: float | None = None
) -> dict[str, Any]:
    """Return what is found in a folder of photographs, as COCO's one object.

    ``images`` has every photograph (id, file_name below the folder, width, height), ``categories`` the classes that
    were found, ``annotations`` a row for each find: ``bbox`` (x, y, w, h) of edges in pixels, ``score``, and
    ``segmentation`` where there is a mask. Photographs are turned as their EXIF data say.

    Args:
        names: Detectors and segmenters of colour, or their run folders, joined by +.
        folder: Photographs: .jpg, .jpeg, .png, .bmp, .webp, in folders below it, too.
        progress: Called with the fraction that is done.
        min_score: As ``open_stages`` takes it.

    Raises:
        UnknownNameError: A name is none of these.
        InputError: The folder holds no photograph, one cannot be read, or a network reads depth.
    """
    stages = open_stages(names, min_score=min_score)
    for name, stage in zip(names.split("+"), stages, strict=True):
        if stage.reads_depth:
            raise InputError(f"{name} reads depth, which photographs lack; take one that reads colour: detector-rgb")
    if not folder.is_dir():
        raise InputError(f"{folder}: is not a folder; name one of photographs ({', '.join(_SUFFIXES)})")
    paths = sorted(path for path in folder.rglob("*") if path.suffix.lower() in _SUFFIXES and path.is_file())
    if not paths:
        raise InputError(f"{folder}: holds no photograph ({', '.join(_SUFFIXES)})")
    for path in paths:  # a broken one is found before any is looked at, which takes longer
        _read(path)
    images, finds = list[dict[str, Any]](), list[tuple[int, RgbdImage, Detection]]()
    for number, path in enumerate(paths, start=1):
        rgb = _read(path)
        height, width, _ = rgb.shape
        images.append(
            {"id": number, "file_name": path.relative_to(folder).as_posix(), "width": width, "height": height}
        )
        image, found = _found(rgb, stages)
        finds += [(number, image, item) for item in found]
        if progress:
            progress(number / len(paths), f"{len(finds)} found")
    categories = numbered(item.class_name for _, _, item in finds)
    rows = [
        {"id": place, "image_id": number, **_row(item, image), "category_id": categories[item.class_name]}
        for place, (number, image, item) in enumerate(finds, start=1)
    ]
    named = [{"id": number, "name": name} for name, number in categories.items()]
    return {"images": images, "categories": named, "annotations": rows}


def _found(rgb: UInt8[np.ndarray, "h w 3"], stages: Sequence[FrontEnd]) -> tuple[RgbdImage, Sequence[Detection]]:
    height, width, _ = rgb.shape
    # Networks of colour look at boxes in pixels: which focal length is stated changes nothing that they find.
    camera = PinholeCamera.from_focal(width, height, float(max(width, height)))
    image = passed(RgbdImage(camera, np.zeros((height, width), dtype=np.float32), (), rgb), stages)
    return image, image.detections


def _row(item: Detection, image: RgbdImage) -> dict[str, Any]:
    found = found_object(item, image)
    row: dict[str, Any] = {"score": round(found.score, 4), "iscrowd": 0}
    if found.edges is not None:
        left, top, right, bottom = found.edges
        row |= {"bbox": [left, top, right - left, bottom - top], "area": (right - left) * (bottom - top)}
    if found.mask is not None:
        row |= {"segmentation": compressed(run_lengths(found.mask)), "area": int(found.mask.sum())}
    return row


def _read(path: Path) -> UInt8[np.ndarray, "h w 3"]:
    """Return a photograph's colours.

    Raises:
        InputError: It cannot be read.
    """
    try:
        data = np.frombuffer(path.read_bytes(), np.uint8)
    except OSError as problem:
        raise InputError(f"{path}: cannot be read ({problem.strerror})") from problem
    image = cv2.imdecode(data, cv2.IMREAD_COLOR) if data.size else None
    if image is None:
        raise InputError(f"{path}: is no image that can be read, or is cut off; take it out of the folder")
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2RGB))
