"""The drives of a dataset, and its estimates filtered along them."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.dataset.stored.scene_record import read_scene_record
from warehouse_sim.errors import InputError
from warehouse_sim.estimators.pose.uncertainty.covariance import rms_quantile, surface_metric
from warehouse_sim.estimators.pose.uncertainty.estimator import NINE_OF_TEN
from warehouse_sim.estimators.tracking.tracker import Tracker, View
from warehouse_sim.schema import PoseEstimate

_SECONDS_AN_IMAGE = 0.1
"""Between images of a sequence whose times nobody stored (s)."""


def tracked(reader: DatasetReader, split: str, estimates: Sequence[PoseEstimate]) -> list[PoseEstimate]:
    """Return the estimates of a split after filtering along its drives; each image sees those before it, none after.

    Images of no drive keep theirs. A dataset that says nothing of drives, as BOP's, has one a scene.

    Args:
        reader: The dataset.
        split: Which of its splits.
        estimates: Of that split, with covariances.

    Raises:
        InputError: No estimate has a covariance, or images of a drive do not say where the camera is.
        DatasetError: A scene's record is malformed.
    """
    if estimates and not any(item.covariance is not None for item in estimates):
        raise InputError(
            "no estimate has a covariance, without which nothing can be filtered; predict with uncertainty "
            "(docs/uncertainty.md names the settings that it was fitted for), or leave --track out"
        )
    by_image: dict[tuple[int, int], list[PoseEstimate]] = {}
    for item in estimates:
        by_image.setdefault((item.scene_id, item.image_id), []).append(item)
    symmetries = {number: info.symmetry for number, info in reader.objects.items()}
    for drive in drives(reader, split):
        tracker = Tracker(symmetries)
        for view in drive:
            key = view.scene_id, view.image_id
            by_image[key] = tracker.step(view, by_image.get(key, []))
    order = [(image.scene_id, image.image_id) for image in reader.images(split)]
    bounds = _Bounds(reader)
    return [bounds.of(item) for key in order for item in by_image.get(key, [])]


def drives(reader: DatasetReader, split: str) -> list[list[View]]:
    """Return the images of each drive of a split in the order of time.

    Raises:
        InputError: An image of a drive does not say where the camera is.
    """
    found: dict[tuple[int, int], list[View]] = {}
    images = reader.images(split)
    numbers = {image.scene_id for image in images} if reader.manifest is not None else set[int]()
    records = {number: read_scene_record(reader.root, number) for number in numbers}
    for image in images:
        sequence, time = 0, image.image_id * _SECONDS_AN_IMAGE
        if image.scene_id in records:
            record = records[image.scene_id].observations[image.image_id]
            if record.sequence is None:
                continue
            sequence, time = record.sequence, record.time
        found.setdefault((image.scene_id, sequence), []).append(_view(image, time))
    return [sorted(views, key=lambda view: view.time) for _, views in sorted(found.items())]


def _view(image: ImageRecord, time: float) -> View:
    if np.array_equal(image.T_world_camera, np.eye(4)):
        raise InputError(
            f"scene {image.scene_id}, image {image.image_id} does not say where the camera is; "
            "tracks are of the world, so leave --track out"
        )
    return View(image.scene_id, image.image_id, image.camera, image.T_world_camera, time)


class _Bounds:
    """Says what a covariance means for the surface of each object."""

    def __init__(self, reader: DatasetReader) -> None:
        self._reader, self._moments = reader, dict[int, tuple[np.ndarray, np.ndarray]]()

    def of(self, item: PoseEstimate) -> PoseEstimate:
        """Return an estimate with the errors that follow from its covariance, if it has one."""
        if item.covariance is None or item.rejected or item.obj_id not in self._reader.objects:
            return item
        if item.obj_id not in self._moments:
            points = self._reader.objects[item.obj_id].model_points()
            self._moments[item.obj_id] = points.mean(axis=0), np.cov(points.T)
        metric = surface_metric(item.T_camera_object, *self._moments[item.obj_id])
        middle, bound = (rms_quantile(item.covariance, metric, z) for z in (0.0, NINE_OF_TEN))
        return replace(item, predicted_error=middle, error_bound=bound)
