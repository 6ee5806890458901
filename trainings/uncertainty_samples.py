"""Estimates under errors of masks and of sensors, with what is seen of them and how wrong they are."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from warehouse_sim.benchmark.disturbances import MASK_ERRORS, Disturb
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.estimators.api import PoseEstimator
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.pose.uncertainty.estimator import Watcher
from warehouse_sim.estimators.predict import read_images
from warehouse_sim.estimators.settings import IMAGES_AT_ONCE
from warehouse_sim.evaluation.measuring import measure
from warehouse_sim.evaluation.trust import succeeded
from warehouse_sim.schema import PoseEstimate


@dataclass(frozen=True, eq=False)
class Samples:
    """k estimates; one array a column."""

    names: tuple[str, ...]
    """Names of the features."""
    features: np.ndarray
    """(k, f)"""
    covariance: np.ndarray
    """(k, 6, 6), from the readings alone."""
    metric: np.ndarray
    """(k, 6, 6)"""
    error: np.ndarray
    """RMS distance of the surface (m)."""
    right: np.ndarray
    """Whether it docks, or of objects without pockets, has ADD under 5 % of the diameter."""
    distance: np.ndarray
    """To the true object (m)."""
    scene: np.ndarray
    """Number of the scene; those of the same seed are alike whatever the sensor."""
    group: np.ndarray
    """Dataset and disturbance."""

    def select(self, rows: np.ndarray) -> "Samples":
        """Return some rows."""
        return Samples(self.names, *(getattr(self, name)[rows] for name in _COLUMNS))

    def save(self, path: Path) -> None:
        """Write them to one file."""
        path.parent.mkdir(parents=True, exist_ok=True)
        np.savez(path, names=np.array(self.names), **{name: getattr(self, name) for name in _COLUMNS})

    @classmethod
    def load(cls, path: Path) -> "Samples":
        """Read what ``save`` wrote."""
        with np.load(path, allow_pickle=False) as data:
            return cls(tuple(data["names"].tolist()), *(data[name] for name in _COLUMNS))


_COLUMNS = ("features", "covariance", "metric", "error", "right", "distance", "scene", "group")


def joined(parts: Sequence[Samples]) -> Samples:
    """Return the rows of all parts."""
    return Samples(parts[0].names, *(np.concatenate([getattr(part, name) for part in parts]) for name in _COLUMNS))


def collect(estimator: PoseEstimator, data: Path, split: str, disturbance: str, every: int = 1) -> Samples:
    """Estimate a split under one disturbance and look at what comes out.

    Args:
        estimator: An estimator without uncertainty of its own.
        data: Dataset folder.
        split: "train", "val" or "test".
        disturbance: Name among ``MASK_ERRORS``.
        every: Every so manyth image.
    """
    reader = DatasetReader(data)
    records = reader.images(split)[::every]
    images = list(read_images(estimator, reader, records))
    disturb, seen = MASK_ERRORS[disturbance], {}

    def remembered(image, rng):  # type: ignore[no-untyped-def]
        seen[image.scene_id, image.image_id] = disturb(image, rng)
        return seen[image.scene_id, image.image_id]

    estimates = predict(estimator, images, remembered)
    watcher = Watcher(lambda obj_id: reader.objects[obj_id].mesh() if reader.objects[obj_id].has_cad else None)
    looks = watcher(list(seen.values()), estimates)
    table = measure(estimates, records, reader.objects)
    table = table.select(table.found)
    rows = [row for row in range(len(table)) if looks[table.prediction[row]] is not None]
    found = [looks[table.prediction[row]] for row in rows]
    names = tuple(found[0].features)
    return Samples(
        names,
        np.array([[item.features[name] for name in names] for item in found]),
        np.stack([item.covariance for item in found]),
        np.stack([item.metric for item in found]),
        table.surface_rms[rows],
        succeeded(table)[rows],
        table.distance[rows],
        table.scene_id[rows],
        np.array([f"{data.name}, {disturbance}"] * len(rows)),
    )


def predict(estimator: PoseEstimator, images: Sequence[RgbdImage], disturb: Disturb) -> list[PoseEstimate]:
    """Return the estimates of disturbed images; each has a random stream of its own."""
    changed = [disturb(item, np.random.default_rng([0, item.scene_id, item.image_id])) for item in images]
    groups = [changed[start : start + IMAGES_AT_ONCE] for start in range(0, len(changed), IMAGES_AT_ONCE)]
    return [estimate for group in groups for estimate in estimator.estimate_all(group)]
