"""The training of a segmenter: datasets become crops about boxes, masks and key points, which are trained on."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import ClassVar

import numpy as np
import torch
from jaxtyping import Float, Int
from torch import Tensor

from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.reader import DatasetReader, ImageRecord, TargetRecord
from warehouse_sim.errors import DatasetError, TrainingError, UnknownNameError
from warehouse_sim.estimators.images.rows import ImageReader
from warehouse_sim.estimators.images.streamed import ObservedAmong
from warehouse_sim.estimators.segmenters.segnet.keypoints import POINTS, face_points, pocket_faces, side_points
from warehouse_sim.estimators.segmenters.segnet.network import KnownFaces, SegmenterNetworkConfig, SegmenterRun
from warehouse_sim.estimators.segmenters.segnet.settings import BoxCropConfig, SegmenterConfig, TrainableSegmenter
from warehouse_sim.estimators.segmenters.segnet.task import Boxes, BoxRows, SegmentationTask
from warehouse_sim.estimators.segmenters.segnet.window import Edges, Window
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.learning.job import Started, TrainingJob
from warehouse_sim.learning.loop import Order
from warehouse_sim.learning.run_folder import RunConfig
from warehouse_sim.learning.samples.array_store import Arrays
from warehouse_sim.learning.samples.order import SampleOrder
from warehouse_sim.learning.samples.split import load_rows, reports_reading, require_other_scenes, split_images
from warehouse_sim.learning.samples.stream_window import Arrivals, seed_since, window_of
from warehouse_sim.learning.settings import Progress
from warehouse_sim.learning.trainable import OpenStream
from warehouse_sim.schema import Observation

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


_MOST_BOXES = 1 << 31
"""More boxes than a window shows: what came at a step is numbered from the step times this."""


class StreamedBoxes:
    """The boxes of a stream's window and the order in which steps draw them; both depend on the step alone.

    Args:
        open_stream: Gives the observations.
        config: Settings, which name the stream.
        crop: How boxes are cut out.
        objects: Objects of the data.

    Raises:
        TrainingError: Nothing opens the stream.
    """

    def __init__(
        self,
        open_stream: OpenStream | None,
        config: SegmenterConfig,
        crop: BoxCropConfig,
        objects: Mapping[int, ObjectInfo],
    ) -> None:
        self._config, self._crop, self._objects = config, crop, objects
        self._arrivals = Arrivals(window_of(open_stream, config.stream, self._rows), self._gathered)

    def indices(self, step: int) -> Int[Tensor, " b"]:
        """Return the numbers of one step's boxes."""
        arrived, (_, order) = self._arrivals.at(step)
        return order.indices(step - arrived) + arrived * _MOST_BOXES

    def at(self, index: int) -> tuple[Arrays, int]:
        """Return the arrays that hold a box of this step or the one before, and its row there."""
        arrived, row = divmod(index, _MOST_BOXES)
        return self._arrivals.since(arrived)[0].at(row)

    def _gathered(self, shown: list[Arrays | None], arrived: int) -> tuple[BoxRows, SampleOrder]:
        parts = [part for part in shown if part is not None]
        rows = BoxRows(parts, [wanted_rows(part["facts"], self._objects, self._config) for part in parts])
        if not len(rows):
            raise TrainingError("none of the stream's observations, in a window, shows a target well enough")
        return rows, SampleOrder(len(rows), self._config.batch, seed_since(self._config.seed, arrived))

    def _rows(self, observation: Observation) -> Arrays | None:
        image = ObservedAmong(observation, self._objects)
        return target_rows(image, image.record, self._crop)


def numbered_kinds(readers: Sequence[DatasetReader], kinds: Sequence[str]) -> dict[int, int]:
    """Return the position of each kind by its obj_id.

    Raises:
        UnknownNameError: No object of the datasets has the name.
        TrainingError: Datasets give the number of a kind to different objects.
    """
    names = {info.name: number for reader in readers for number, info in reader.objects.items()}
    if strange := [name for name in kinds if name not in names]:
        raise UnknownNameError("object of the datasets under kinds", strange[0], list(names))
    positions = {names[name]: position for position, name in enumerate(kinds)}
    for reader in readers:
        for number, info in reader.objects.items():
            expected = kinds[positions[number]] if number in positions else None
            if (expected or info.name in kinds) and expected != info.name:
                raise TrainingError(
                    f"{reader.root}: object {number} is {info.name}, which has another number in another dataset; "
                    "train on datasets whose numbers agree, or with other kinds"
                )
    return positions


def known_faces(readers: Sequence[DatasetReader]) -> tuple[KnownFaces, ...]:
    """Return the objects with pockets of some datasets, by number."""
    objects = {number: info for reader in readers for number, info in reader.objects.items()}
    return tuple(_faces(info) for _, info in sorted(objects.items()) if info.pockets)


def _faces(info: ObjectInfo) -> KnownFaces:
    sides = [side_points(info.size, info.pockets, face) for face in pocket_faces(info.pockets)]
    return KnownFaces(
        info.obj_id,
        info.name,
        info.class_name,
        tuple(tuple(float(value) for value in points.ravel()) for points, _ in sides),
        tuple(tuple(bool(value) for value in known) for _, known in sides),
    )


@dataclass(frozen=True)
class SegmenterJob(TrainingJob):
    """A training of a segmenter."""

    method: TrainableSegmenter
    config: SegmenterConfig

    run_config: ClassVar[type[RunConfig]] = SegmenterRun
    samples: ClassVar[str] = "boxes"
    watched: ClassVar[tuple[str, str]] = ("val_iou", "validation IoU {:.1f} %")

    @property
    def is_small(self) -> bool:
        """Whether the network gains little from several threads."""
        return self.config.width <= 24

    def start(self, progress: Progress | None = None) -> Started:
        """Read the samples and make a fresh network."""
        readers, method = self.readers(), self.method
        crop = BoxCropConfig(method.reads)
        rows = prepare(readers, crop, self.config, self.cache_dir, progress)
        config = SegmenterRun(
            **self.origin(readers),
            objects=known_faces(readers) if method.keypoints else (),
            crop=crop,
            network=SegmenterNetworkConfig(
                method.reads, self.config.width, POINTS if method.keypoints else 0, self.config.kinds
            ),
        )
        torch.manual_seed(self.config.seed)
        counts, stream, remark = {split: len(part) for split, part in rows.items()}, self.config.stream, ""
        objects = {number: info for reader in readers for number, info in reader.objects.items()}
        kinds = numbered_kinds(readers, self.config.kinds)
        train: Boxes
        order: Order
        if stream.recipe:
            require_other_scenes(readers, stream)
            order = train = StreamedBoxes(self.open_stream, self.config, crop, objects)
            remark = f"train: the stream of {stream.recipe}, seed {stream.seed}"
        else:
            order, train = SampleOrder(len(rows["train"]), self.config.batch, self.config.seed), rows["train"]
        task = SegmentationTask(config.make_network(), self.config, crop, train, rows["val"], order, kinds)
        return Started(task, order, config, counts, remark)
