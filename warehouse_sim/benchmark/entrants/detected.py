"""What detectors find in a dataset is kept, image by image: all estimators that share a detector share its answers."""

import json
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from warehouse_sim.benchmark.kept import folder_for
from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.estimators.api import FrontEnd, PoseEstimator
from warehouse_sim.estimators.detections import GT, GT_BOXES, Finder, is_detections
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.settings import DepthSource, PredictConfig
from warehouse_sim.geometry.boxes import mask_box_xyxy
from warehouse_sim.output import make_folder, whole_file

SEEN = "seen"
"""Folder of the benchmark that holds what was found."""
_PARTS = ("mask", "mask_probability")


class KeptFinder(Finder):
    """Finds what was found before in the files that it left.

    Args:
        config: Names the detectors, and what they see.
        inputs: All that decides what they find, besides the images' names and the depth.
        folder: Where the files of a dataset lie; None keeps nothing.
    """

    def __init__(self, config: PredictConfig, inputs: Mapping[str, object], folder: Path | None) -> None:
        super().__init__(config.detections, config.gravity, config.depth, config.objects)
        names = config.detections.split("+")
        can_be_kept = names[0] not in (GT, GT_BOXES) and not any(map(is_detections, names))
        self._folder = folder_for(folder, config.detections, inputs) if folder is not None and can_be_kept else None
        self._seconds: float | None = None

    def find(self, estimator: PoseEstimator, reader: DatasetReader, image: ImageRecord) -> RgbdImage | None:
        """Return an image with its detections, see ``Finder``; ``seconds`` is what they took when they were found."""
        self._seconds = None
        found = super().find(estimator, reader, image)
        if self._seconds is not None:
            self.seconds = self._seconds
        return found

    def _passed(self, image: RgbdImage, stages: Sequence[FrontEnd], source: DepthSource) -> RgbdImage:
        if self._folder is None or not stages:
            return super()._passed(image, stages, source)
        path = self._folder / source / f"{image.scene_id:06d}_{image.image_id:06d}.npz"
        if not path.is_file():
            started = time.perf_counter()
            found = super()._passed(image, stages, source)
            make_folder(path.parent)
            write_found(path, found.detections, time.perf_counter() - started)
        detections, self._seconds = read_found(path, image.depth.shape)
        return replace(image, detections=detections)


def write_found(path: Path, detections: Sequence[Detection], seconds: float) -> None:
    """Write the detections of an image with the time that they took (s); of masks no more than the part that is set."""
    rows, arrays = list[dict[str, Any]](), dict[str, Any]()
    for number, item in enumerate(detections):
        row: dict[str, Any] = {
            "model": item.model if isinstance(item.model, str | None) else int(item.model),
            "score": float(item.score),
            "number": None if item.number is None else int(item.number),
            "box_xyxy": None if item.box_xyxy is None else [float(edge) for edge in item.box_xyxy],
            "class_name": item.class_name,
            "may_be": list(item.may_be),
            "kind_likelihood": dict(item.kind_likelihood),
        }
        for name in _PARTS:
            whole = getattr(item, name)
            if whole is not None:
                left, top, right, bottom = mask_box_xyxy(whole != 0) or (0, 0, -1, -1)
                arrays[f"{name}_{number}"] = whole[top : bottom + 1, left : right + 1]
                row[name] = [left, top]
        rows.append(row)
    with whole_file(path) as file:
        np.savez_compressed(file, rows=np.array(json.dumps([seconds, rows])), **arrays)


def read_found(path: Path, size_hw: tuple[int, ...]) -> tuple[tuple[Detection, ...], float]:
    """Return what ``write_found`` wrote, for an image of a height and a width."""
    with np.load(path, allow_pickle=False) as file:
        seconds, rows = json.loads(str(file["rows"]))
        found = []
        for number, row in enumerate(rows):
            for name in _PARTS:
                if name in row:
                    (left, top), part = row[name], file[f"{name}_{number}"]
                    whole = np.zeros(size_hw, part.dtype)
                    whole[top : top + part.shape[0], left : left + part.shape[1]] = part
                    row[name] = whole
            box = row.pop("box_xyxy")
            found.append(Detection(**row | {"may_be": tuple(row["may_be"]), "box_xyxy": box and tuple(box)}))
    return tuple(found), float(seconds)
