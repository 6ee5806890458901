"""Estimate the targets of a split with a trained run."""

import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.icp import refine_pose
from warehouse_sim.estimators.runner import Proposals, Runner
from warehouse_sim.estimators.select import select_pose
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.estimators.surface import CadSurface, build_surface
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.learning.crops import Crop, image_crops
from warehouse_sim.learning.progress import Progress
from warehouse_sim.schema import PoseEstimate

_SURFACE_SAMPLES = 20_000


def predict(
    run: Path, data: Path, split: str, config: PredictConfig, progress: Progress | None = None
) -> list[PoseEstimate]:
    """Estimate every target of ``split`` that is visible enough, in order of images.

    Args:
        run: Run folder of a trained estimator.
        data: Dataset folder with BOP files.
        split: "train", "val" or "test".
        config: Settings.
        progress: Told the share that is done.

    Returns:
        Poses with the network's confidence as score and the seconds spent on the image as time, in which the network
        counts with its share by targets.

    Raises:
        TrainingError: The run is incomplete or does not know the split's objects.
        DatasetError: The folder is no dataset with BOP files.
    """
    reader, chain = DatasetReader(data), _Chain(run, config)
    images = reader.images(split)
    if not images:
        raise TrainingError(f"{data}: the split {split!r} has no images; generate more scenes")
    chain.meet_objects(reader, {target.obj_id for image in images for target in image.targets})
    estimates: list[PoseEstimate] = []
    for start in range(0, len(images), config.images_at_once):
        group = images[start : start + config.images_at_once]
        estimates += chain.estimate(reader, group)
        if progress:
            progress((start + len(group)) / len(images), f"{len(estimates)} poses")
    return estimates


class _Chain:
    """Crops to poses: propose, select, refine."""

    def __init__(self, run: Path, config: PredictConfig) -> None:
        self._runner, self._config = Runner(run), config
        self._symmetries: dict[int, SymmetryGroup] = {}
        self._surfaces: dict[int, CadSurface] = {}
        self._diameters: dict[int, float] = {}

    def meet_objects(self, reader: DatasetReader, obj_ids: set[int]) -> None:
        """Read what is needed of the dataset's objects, and check that the network knows them."""
        known = {shape.obj_id: shape for shape in self._runner.config.objects}
        for obj_id in sorted(obj_ids):
            info = reader.objects[obj_id]
            if obj_id not in known or known[obj_id].name != info.name:
                names = ", ".join(f"{shape.obj_id} {shape.name}" for shape in known.values())
                raise TrainingError(f"the run was not trained on object {obj_id} {info.name}; it knows: {names}")
            self._symmetries[obj_id], self._diameters[obj_id] = info.symmetry, info.diameter
            if self._config.refine == "icp":
                rng = np.random.default_rng([self._config.seed, obj_id])
                self._surfaces[obj_id] = build_surface(info.mesh(), _SURFACE_SAMPLES, rng)

    def estimate(self, reader: DatasetReader, images: list[ImageRecord]) -> list[PoseEstimate]:
        """Return the poses of all targets of a few images."""
        crops, seconds = [], dict[tuple[int, int], float]()
        for image, found, spent in self._cut(reader, images):
            crops += found
            seconds[image.scene_id, image.image_id] = spent
        if not crops:
            return []
        started = time.perf_counter()
        proposals = self._runner.propose(crops, self._config.seed)
        T = np.stack([self._select(crop, proposals, k) for k, crop in enumerate(crops)])
        T = self._runner.refine(proposals, T)
        share = (time.perf_counter() - started) / len(crops)
        for k, crop in enumerate(crops):
            started = time.perf_counter()
            if self._config.refine == "icp":
                T[k] = refine_pose(T[k], crop.points, self._surfaces[crop.obj_id], self._config.icp)
            seconds[crop.scene_id, crop.image_id] += share + time.perf_counter() - started
        scores = proposals.confidences.max(axis=1)
        return [
            PoseEstimate(*_key(crop), crop.obj_id, float(score), pose, seconds[_key(crop)])
            for crop, score, pose in zip(crops, scores, T, strict=True)
        ]

    def _cut(self, reader: DatasetReader, images: list[ImageRecord]) -> Iterator[tuple[ImageRecord, list[Crop], float]]:
        for image in images:
            started = time.perf_counter()
            found = list(image_crops(reader, image, self._runner.config.crop, self._config.seed))
            yield image, found, time.perf_counter() - started

    def _select(self, crop: Crop, proposals: Proposals, k: int) -> np.ndarray:
        return select_pose(
            proposals.rotations[k],
            proposals.translations[k],
            proposals.confidences[k],
            self._symmetries[crop.obj_id],
            self._diameters[crop.obj_id],
            self._config.selection,
        )


def _key(crop: Crop) -> tuple[int, int]:
    return crop.scene_id, crop.image_id
