"""Where the detections of a dataset's images come from: its masks, files, or detectors and segmenters by name."""

import os
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.dataset.results.detections import FoundObject, is_label_folder, read_labels, read_results
from warehouse_sim.errors import DatasetError, InputError, UnknownNameError
from warehouse_sim.estimators.api import Detector, FrontEnd, PoseEstimator
from warehouse_sim.estimators.gravity import GravitySource, down_from_floor
from warehouse_sim.estimators.image import Detection, RgbdImage, SweepView
from warehouse_sim.estimators.lidar.projection import read_sweep, sweep_points, with_lidar_depth
from warehouse_sim.estimators.matching import known_among, taken_by
from warehouse_sim.estimators.pipeline import passed
from warehouse_sim.estimators.registries import DETECTORS, FRONT_ENDS, SEGMENTERS
from warehouse_sim.estimators.settings import DepthSource
from warehouse_sim.learning.run_folder import read_kind
from warehouse_sim.resources import model_dir, model_names


def open_front_end(name_or_run: str | Path) -> FrontEnd:
    """Return what finds objects in an image, or outlines those that its detections name.

    Args:
        name_or_run: Registered name of a detector or a segmenter, or the run folder of a trained one.

    Raises:
        UnknownNameError: Neither a name nor a folder.
        InputError: The folder holds something else.
        TrainingError: There are no weights, or they cannot be read.
    """
    name = str(name_or_run)
    if name in DETECTORS.names():
        return adapted_front_end(DETECTORS.get(name)())
    if name in SEGMENTERS.names():
        return adapted_front_end(SEGMENTERS.get(name)())
    bundled = model_names()
    if not os.path.isdir(name_or_run) and name not in bundled:
        known = {*DETECTORS.names(), *SEGMENTERS.names(), *(item for item in bundled if _finds(model_dir(item)))}
        raise UnknownNameError("detector or segmenter (or the run folder of one)", name, sorted(known))
    folder = model_dir(name_or_run)
    if not _finds(folder):
        raise InputError(f"{name} holds a run of the kind {read_kind(folder)}, which finds no objects")
    return adapted_front_end(FRONT_ENDS.get(read_kind(folder))(folder))


def _finds(folder: Path) -> bool:
    return read_kind(folder) in FRONT_ENDS.names()


def adapted_front_end(found: Any) -> FrontEnd:
    """Return a detector or segmenter of this package as it is, and any other with ``detect`` or ``segment`` as one."""
    return found if isinstance(found, FrontEnd) else OwnFrontEnd(found)


class OwnFrontEnd(FrontEnd):
    """A user's own detector or segmenter.

    Args:
        inner: An object with ``segment(image)`` or ``detect(image)``, which may have the properties of a ``FrontEnd``.
    """

    reads_rgb: bool = True
    reads_depth: bool = False
    reads_sweep: bool = False
    depth_source: DepthSource = "camera"
    needs_detections: bool = False

    def __init__(self, inner: Any) -> None:
        self._find: Callable[[RgbdImage], Sequence[Detection]] = (
            inner.segment if hasattr(inner, "segment") else inner.detect
        )
        for name in ("reads_rgb", "reads_depth", "reads_sweep", "depth_source", "needs_detections"):
            setattr(self, name, getattr(inner, name, getattr(type(self), name)))

    def __call__(self, image: RgbdImage, /) -> Sequence[Detection]:
        """Return what it finds."""
        return self._find(image)


def found_object(item: Detection, image: RgbdImage) -> FoundObject:
    """Return a detection of an image as files hold it."""
    edges = None
    if item.box_xyxy is not None:
        left, top, right, bottom = item.box_xyxy
        # A box holds pixel centres, which lie half a pixel within its edges.
        edges = (left + 0.5, top + 0.5, right + 0.5, bottom + 0.5)
    place = image.scene_id, image.image_id
    return FoundObject(*place, item.score, item.class_name, item.model, edges, item.mask, item.kind_likelihood)


def detection(item: FoundObject) -> Detection:
    """Return what a file holds as a detection."""
    box = None
    if item.edges is not None:
        left, top, right, bottom = item.edges
        box = (left - 0.5, top - 0.5, right - 0.5, bottom - 0.5)
    kinds = item.kind_likelihood
    return Detection(item.mask, item.model, item.score, box_xyxy=box, class_name=item.class_name, kind_likelihood=kinds)


class StoredDetections(Detector):
    """What a file says of the images of a dataset; a stage like a detector.

    Args:
        path: COCO's or BOP's results, or a folder of YOLO's label files.
        reader: The dataset.

    Raises:
        DatasetError: The file is malformed, or was made for another dataset.
    """

    reads_depth = False

    def __init__(self, path: Path, reader: DatasetReader) -> None:
        self._by_image: dict[tuple[int, int], list[Detection]] = {}
        parts = [_read(path, reader, split) for split in reader.parts]
        for item in (item for part in parts for item in part):
            self._by_image.setdefault((item.scene_id, item.image_id), []).append(detection(item))

    def detect(self, image: RgbdImage) -> Sequence[Detection]:
        """Return what the file says of an image."""
        return self._by_image.get((image.scene_id, image.image_id), [])


def is_detections(path: str | Path) -> bool:
    """Return whether a path is a file of detections or a folder of them."""
    # Unlike those of Path, these take what is too long for a path.
    return os.path.isfile(path) or (os.path.isdir(path) and is_label_folder(Path(path)))


def _read(path: Path, reader: DatasetReader, split: str) -> list[FoundObject]:
    if path.is_file():
        return read_results(path, reader, split)
    try:
        return read_labels(path, reader, split)
    except DatasetError:
        # Mostly a folder holds one split; it is wrong only where it holds none.
        if any(path.rglob("*_*.txt")) or any(path.rglob("[0-9]*.txt")):
            return []
        raise


AUTO, GT, GT_BOXES = "auto", "gt", "gt-boxes"


class Finder:
    """Reads images of a dataset with what is detected in them that an estimator can take.

    Args:
        names: Detectors, segmenters, run folders of them or files of detections, joined by +, each working on what the
            one before found; the first may be "gt" or "gt-boxes", what the dataset says. "auto" leaves it to
            estimators that find objects themselves, and is "gt" for others.
        gravity: Who says where down is.
        depth: Whose depth is seen; None asks the estimator and the detector for their ``depth_source``, the camera's if
            they have none.
        objects: Names of the objects that there are, see ``taken_by``; by default those of the dataset.

    Raises:
        UnknownNameError: A name is none of these.
    """

    def __init__(
        self,
        names: str = GT,
        gravity: GravitySource = "rig",
        depth: DepthSource | None = None,
        objects: Sequence[str] = (),
    ) -> None:
        self._objects = tuple(objects)
        self._gravity, self._depth, self._is_auto = gravity, depth, names == AUTO
        first, *more = (GT if names == AUTO else names).split("+")
        self._gt = first if first in (GT, GT_BOXES) else None
        self._names = more if self._gt else [first, *more]
        # Files are read once the dataset is known; a name that is none is rejected at once.
        self._stages = None if any(map(is_detections, self._names)) else self._opened()
        self.seconds = 0.0
        """How long the last image's detection and the filling of its depth took."""

    def takes_gt(self, estimator: PoseEstimator) -> bool:
        """Return whether an estimator is given what the dataset's labels say."""
        return self._gt is not None and not (self._is_auto and estimator.finds_objects)

    def find(self, estimator: PoseEstimator, reader: DatasetReader, image: ImageRecord) -> RgbdImage | None:
        """Return an image with its detections; None where there are none, and the estimator finds none itself.

        Raises:
            DatasetError: The LiDAR's depth is requested, and the dataset holds no sweep of the image; or depth is
                needed, and it holds none.
        """
        if self._stages is None:
            self._stages = self._opened(reader)
        source = self._depth or estimator.depth_source or (self._stages[0].depth_source if self._stages else "camera")
        finds = self._is_auto and estimator.finds_objects
        if self._gt is None or finds:
            given: RgbdImage | None = read_image(reader, image, needs_depth([estimator, *self._stages], source))
        else:
            given = _with_gt(estimator, reader, image, self._gt == GT_BOXES)
        if given is None:
            return None
        found = self._with_gravity(given)
        started = time.perf_counter()
        found = with_depth_of(source, found, reader, image)
        if estimator.reads_sweep or any(stage.reads_sweep for stage in self._stages):
            found = with_sweep(found, reader, image)
        found = self._passed(found, self._stages, source)
        self.seconds = time.perf_counter() - started if self._stages or source != "camera" else 0.0
        if finds:
            return found
        # Estimates refer to what the detector found, whatever of it is estimated.
        numbered = tuple(replace(item, number=item.number_at(i)) for i, item in enumerate(found.detections))
        taken = taken_by(estimator, numbered, self._objects or known_among(estimator, reader.objects))
        return replace(found, detections=taken) if taken else None

    def _passed(self, image: RgbdImage, stages: Sequence[FrontEnd], source: DepthSource) -> RgbdImage:
        """Return an image with what its stages find in it.

        Args:
            image: With the depth that is seen.
            stages: Detectors and segmenters, in order.
            source: Whose depth that is.
        """
        return passed(image, stages)

    def _opened(self, reader: DatasetReader | None = None) -> list[FrontEnd]:
        if not self._names:
            return []
        try:
            return open_stages("+".join(self._names), reader, self._gt is not None)
        except UnknownNameError as problem:
            raise UnknownNameError(problem.kind, problem.name, [AUTO, GT, GT_BOXES, *problem.known]) from None

    def _with_gravity(self, image: RgbdImage) -> RgbdImage:
        if self._gravity == "rig":
            return image
        if self._gravity == "none":
            return replace(image, gravity=None)
        rng = np.random.default_rng([image.scene_id, image.image_id])
        return replace(image, gravity=down_from_floor(image.camera, image.depth, rng))


def open_stages(
    names: str, reader: DatasetReader | None = None, after_gt: bool = False, min_score: float | None = None
) -> list[FrontEnd]:
    """Return what finds objects, one stage after the other; detectors that follow each other are one.

    Args:
        names: Detectors, segmenters, their run folders or files of detections, joined by +.
        reader: The dataset that files are about.
        after_gt: Whether they work on what a dataset says.
        min_score: Detections of lower scores are left out by trained detectors, 0-1; by default as they are made.

    Raises:
        UnknownNameError: A name is none of these.
        DatasetError: A file is malformed, or was made for another dataset.
        InputError: The first stage needs what another finds.
    """
    stages = [
        StoredDetections(Path(name), reader) if reader and is_detections(name) else open_front_end(name)
        for name in names.split("+")
    ]
    stages = _joined(stages)
    for stage in stages:
        if min_score is not None:
            stage.leave_out_below(min_score)
    first = names.split("+")[0]
    if not after_gt and stages[0].needs_detections:
        raise InputError(f"{first} segments objects in boxes; name a detector before it, as detector-depth+{first}")
    return stages


def _joined(stages: Sequence[FrontEnd]) -> list[FrontEnd]:
    joined = list[FrontEnd]()
    for _, group in groupby(stages, lambda stage: isinstance(stage, Detector)):
        alike = list(group)
        detectors = [stage for stage in alike if isinstance(stage, Detector)]
        if len(detectors) > 1:
            # Torch is loaded with it, which those who only read masks go without.
            from warehouse_sim.estimators.detectors.joined import JoinedDetectors

            alike = [JoinedDetectors(detectors)]
        joined += alike
    return joined


def needs_depth(readers: Sequence[PoseEstimator | FrontEnd], source: DepthSource) -> bool:
    """Return whether any of those who read an image needs the camera's depth.

    Args:
        readers: Estimators, detectors and segmenters.
        source: Whose depth they see.
    """
    return source == "camera" and any(item.reads_depth and not item.reads_sweep for item in readers)


def read_image(reader: DatasetReader, image: ImageRecord, depth: bool = False) -> RgbdImage:
    """Read an image without detections; where the dataset has no depth, nothing has a reading.

    Without colours there are none, and who needs them says so.

    Args:
        reader: The dataset.
        image: Which image.
        depth: Whether it is of no use without depth.

    Raises:
        DatasetError: It is, and the dataset has none.
    """
    if depth or reader.has_depth:
        return RgbdImage.from_dataset(reader, image, (), rgb=not reader.leaves_out("rgb"))
    nothing = np.zeros((image.camera.height, image.camera.width), dtype=np.float32)
    return RgbdImage(image.camera, nothing, (), reader.rgb(image), image.scene_id, image.image_id)


def with_depth_of(source: DepthSource, image: RgbdImage, reader: DatasetReader, record: ImageRecord) -> RgbdImage:
    """Return an image with the depth of the camera, as it is, or with that of the main LiDAR.

    Raises:
        DatasetError: The LiDAR's depth is requested, and the dataset holds no sweep of the image.
    """
    if source == "camera":
        return image
    mounted = read_sweep(reader, record, f" for --depth {source}", ", or take --depth camera")
    return with_lidar_depth(image, sweep_points(mounted), source)


def with_sweep(image: RgbdImage, reader: DatasetReader, record: ImageRecord) -> RgbdImage:
    """Return an image with the sweep of the main LiDAR beside it.

    Raises:
        DatasetError: The dataset holds none.
    """
    mounted = read_sweep(reader, record, ", which is what is looked at")
    return replace(image, sweep=SweepView(mounted.reading.points.astype(float), mounted.T_camera_sensor))


def _with_gt(estimator: PoseEstimator, reader: DatasetReader, image: ImageRecord, boxes: bool) -> RgbdImage | None:
    """Read an image with the masks, or boxes, of those targets that the estimator knows and that are seen, if any."""
    known = None if estimator.objects is None else {shape.obj_id for shape in estimator.objects}
    # What has no pose is of an object that nobody named: it is estimated as each that the estimator knows.
    named = [item for item in image.targets if known is None or not item.has_pose or item.obj_id in known]
    targets = [item for item in named if estimator.min_visible.takes(item)]
    if not targets:
        return None
    reads_rgb = estimator.reads_rgb
    if not boxes:
        return RgbdImage.from_dataset(reader, image, targets, rgb=reads_rgb)
    found = (
        Detection(None, item.obj_id if item.has_pose else None, number=item.gt_index, box_xyxy=item.box_visible_xyxy)
        for item in targets
    )
    return replace(RgbdImage.from_dataset(reader, image, (), rgb=reads_rgb), detections=tuple(found))
