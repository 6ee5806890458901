"""A trained estimator as one object: images with detections go in, poses come out."""

import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float

from warehouse_sim.errors import InputError
from warehouse_sim.estimators.calibration import ErrorCurve, read_calibration
from warehouse_sim.estimators.icp import refine_poses
from warehouse_sim.estimators.rgbd_image import Detection, RgbdImage
from warehouse_sim.estimators.runner import Runner
from warehouse_sim.estimators.select import Symmetries, select_poses
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.estimators.surface import CadSurface, build_surface
from warehouse_sim.geometry.pose import Transforms
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.learning.crops import Crop, CropConfig, CropLabel, cut_mask
from warehouse_sim.learning.object_meshes import read_meshes
from warehouse_sim.learning.objects import ObjectShape
from warehouse_sim.resources import model_dir
from warehouse_sim.schema import Observation, PoseEstimate

_SURFACE_SAMPLES = 20_000


class Estimator:
    """Crops, proposals, selection, refiner, and ICP if configured; batched over all objects of some images.

    Args:
        run: Run folder, or folder of a bundled model.
        config: Settings.

    Raises:
        TrainingError: The folder holds no complete run, or no CAD surfaces although ICP is asked for.
    """

    def __init__(self, run: Path, config: PredictConfig = PredictConfig()) -> None:  # noqa: B008  frozen
        self._runner, self.config = Runner(run, config.device, config.threads), config
        self.objects: tuple[ObjectShape, ...] = self._runner.config.objects
        """What it knows, in the order of the network's classes."""
        self._row = {shape.obj_id: i for i, shape in enumerate(self.objects)}
        self._symmetries = Symmetries.of([
            SymmetryGroup(np.reshape(shape.symmetries, (-1, 4, 4))) for shape in self.objects
        ])  # fmt: skip
        self._diameters = np.array([shape.diameter for shape in self.objects])
        self._meshes = read_meshes(run) if config.refine == "icp" else {}
        self._surfaces: dict[int, CadSurface] = {}
        self.calibration: ErrorCurve | None = read_calibration(run).get(config.selection, config.refine)
        """How confidence tells the error; None when it was not fitted for these settings."""

    @property
    def crop(self) -> CropConfig:
        """How objects are cut out, and how much must be seen of them."""
        return self._runner.config.crop

    @property
    def reads_rgb(self) -> bool:
        """Whether images need colour."""
        return self._runner.config.network.reads_rgb

    def estimate(self, image: RgbdImage | Observation) -> list[PoseEstimate]:
        """Return the poses of the detected objects of one image, in order of detections.

        A detection with too few depth readings gets no estimate; ``PoseEstimate.detection`` says which one each
        belongs to. Of a simulated observation, the labelled objects that the estimator knows are estimated.

        Raises:
            InputError: A detection is of an object that the estimator does not know, or colour is missing.
        """
        if isinstance(image, Observation):
            image = self._known_of(RgbdImage.from_observation(image))
        return self.estimate_all([image])

    def estimate_all(self, images: Sequence[RgbdImage]) -> list[PoseEstimate]:
        """Return the poses of the detected objects of several images, which pass the network together.

        The time of an estimate is that of its image, which counts with its share by objects of what is batched.
        """
        crops, owners, seconds = list[Crop](), list[int](), list[float]()
        for number, image in enumerate(images):
            started = time.perf_counter()
            found = self.cut(image)
            crops += found
            owners += [number] * len(found)
            seconds.append(time.perf_counter() - started)
        if not crops:
            return []
        started = time.perf_counter()
        T, confidence = self.estimate_crops(crops)
        share = (time.perf_counter() - started) / len(crops)
        times = [spent + share * owners.count(number) for number, spent in enumerate(seconds)]
        return [
            self._describe(images[owner], crop, pose, float(trust), times[owner])
            for owner, crop, pose, trust in zip(owners, crops, T, confidence, strict=True)
        ]

    def cut(self, image: RgbdImage) -> list[Crop]:
        """Return the crops of the detections that show enough; ``gt_index`` is the position of the detection.

        Raises:
            InputError: A detection is of an object that the estimator does not know, or colour is missing.
        """
        if image.rgb is None and self.reads_rgb:
            raise InputError(f"{self._runner.config.estimator} reads colour, but the image has no rgb")
        found = (self._cut_one(image, position, item) for position, item in enumerate(image.detections))
        return [crop for crop in found if crop is not None]

    def estimate_crops(self, crops: Sequence[Crop]) -> tuple[Transforms, Float[np.ndarray, " b"]]:
        """Return ``T_camera_object`` (b 4 4) and the network's confidence for at least one crop."""
        rows = [self._row[crop.obj_id] for crop in crops]
        proposals = self._runner.propose(crops)
        symmetries, diameters = self._symmetries.rows(rows), self._diameters[rows]
        T = select_poses(proposals.candidates, symmetries, diameters, self.config.selection)
        T = self._runner.refine(proposals, T)
        if self.config.refine == "icp":
            surfaces = [self._surface(crop.obj_id) for crop in crops]
            T = refine_poses(T, [crop.points for crop in crops], surfaces, self.config.icp)
        return T, proposals.candidates.confidence.max(axis=1)

    def _describe(
        self, image: RgbdImage, crop: Crop, T_camera_object: np.ndarray, confidence: float, seconds: float
    ) -> PoseEstimate:
        shape, detection = self.objects[self._row[crop.obj_id]], image.detections[crop.gt_index]
        curve = self.calibration
        return PoseEstimate(
            image.scene_id,
            image.image_id,
            crop.obj_id,
            confidence * detection.score,
            T_camera_object,
            seconds,
            name=shape.name,
            class_name=shape.class_name,
            detection=crop.gt_index if detection.number is None else detection.number,
            predicted_error=curve.error_at(confidence) * shape.diameter if curve else None,
            error_bound=curve.bound_at(confidence) * shape.diameter if curve else None,
        )

    def _known_of(self, image: RgbdImage) -> RgbdImage:
        known = tuple(item for item in image.detections if item.model in self._row)
        return RgbdImage(image.camera, image.depth, known, image.rgb, image.scene_id, image.image_id)

    def _cut_one(self, image: RgbdImage, position: int, detection: Detection) -> Crop | None:
        number = position if detection.number is None else detection.number
        rng = np.random.default_rng([self.config.seed, image.scene_id, image.image_id, number])
        label = CropLabel(image.scene_id, image.image_id, position, self._obj_id(detection), np.eye(4))
        mask = np.asarray(detection.mask, dtype=bool)
        return cut_mask(image.camera, label, mask, image.depth, image.rgb, self.crop, rng)

    def _obj_id(self, detection: Detection) -> int:
        for shape in self.objects:
            if detection.model in (shape.obj_id, shape.name):
                return shape.obj_id
        names = ", ".join(f"{shape.name} ({shape.obj_id})" for shape in self.objects)
        raise InputError(f"the estimator does not know the object {detection.model!r}; it knows: {names}")

    def _surface(self, obj_id: int) -> CadSurface:
        if obj_id not in self._surfaces:
            rng = np.random.default_rng([self.config.seed, obj_id])
            self._surfaces[obj_id] = build_surface(self._meshes[obj_id], _SURFACE_SAMPLES, rng)
        return self._surfaces[obj_id]


def load_estimator(name_or_run: str | Path, config: PredictConfig = PredictConfig()) -> Estimator:  # noqa: B008  frozen
    """Return a bundled estimator by name ("densefusion-pointcloud"), or a trained one by its run folder.

    Args:
        name_or_run: Which one.
        config: How poses are selected and refined.

    Raises:
        UnknownNameError: Neither a bundled name nor a folder.
        TrainingError: The folder holds no complete run.
    """
    return Estimator(model_dir(name_or_run), config)
