"""A trained network of the family as an estimator: crops, proposals, selection, its refiner, and ICP if configured."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path

import numpy as np

from warehouse_sim.errors import InputError, TrainingError
from warehouse_sim.estimators.api import LeastVisible
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.matching import may_be
from warehouse_sim.estimators.pipeline import ObjectPoints, Pipeline, Proposals, Stages, Verdict
from warehouse_sim.estimators.pose.choose import Candidates, Symmetries, select_poses
from warehouse_sim.estimators.pose.densefusion.calibration import ErrorCurve, read_calibration
from warehouse_sim.estimators.pose.densefusion.crops.config import CropConfig
from warehouse_sim.estimators.pose.densefusion.crops.cut import Crop, CropLabel, cut_mask
from warehouse_sim.estimators.pose.densefusion.objects import MESHES, ObjectShape, read_meshes, without_mesh
from warehouse_sim.estimators.pose.densefusion.runner import Runner
from warehouse_sim.estimators.pose.fitting.hypotheses import masked_points
from warehouse_sim.estimators.pose.fitting.search import FitConfig
from warehouse_sim.estimators.pose.fitting.verification import DepthView
from warehouse_sim.estimators.pose.fitting.verification_refiner import VerificationRefiner
from warehouse_sim.estimators.pose.icp.refiner import IcpRefiner
from warehouse_sim.estimators.pose.uncertainty.covariance import agreement
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import SymmetryGroup, Transform, Transforms
from warehouse_sim.schema import Agreement

_FLIGHT_GRAZING = 2.0
"""Power of the cosine by which time of flight is believed on level surfaces."""


class Estimator(Pipeline):
    """The stages of a run folder; batched over all objects of some images.

    Args:
        run: Run folder, or folder of a bundled model.
        config: Settings.

    Raises:
        TrainingError: The folder holds no complete run, or no CAD surfaces although ICP is requested.
    """

    def __init__(self, run: Path, config: PredictConfig = PredictConfig()) -> None:  # noqa: B008  frozen
        self._run = run
        fitted, requested = read_calibration(run), config.refiner_iterations
        iterations = fitted.refiner_iterations if requested is None else requested
        self._runner = Runner(run, config.device, config.threads, iterations)
        self.config = config = config.with_stages(self._has_surfaces())
        self._row = {shape.obj_id: i for i, shape in enumerate(self.objects)}
        groups = [SymmetryGroup(np.reshape(shape.symmetries, (-1, 4, 4))) for shape in self.objects]
        self._symmetries, self._diameters = Symmetries.of(groups), np.array([item.diameter for item in self.objects])
        as_fitted = self._runner.iterations == fitted.refined(self._runner.config.train.refiner_iterations)
        self.calibration: ErrorCurve | None = fitted.get(*config.way) if as_fitted else None
        """How confidence predicts the error; None when it was not fitted for these settings."""
        icp = () if config.refine == "none" else (self._refiner(run),)
        refine = (self._runner.refine, *icp)
        prefer = next((stage.prefer for stage in icp if isinstance(stage, VerificationRefiner)), None)
        stages = Stages(self.cut, self._runner.propose, self._choose, (), refine, self._verify, self._agree, prefer)
        super().__init__(stages)

    @property
    def objects(self) -> tuple[ObjectShape, ...]:
        """What it knows, in the order of the network's classes."""
        return self._runner.config.objects

    @cached_property
    def surfaces(self) -> dict[int, TriangleMesh]:
        """CAD surfaces (m, object frame) by obj_id; empty where the run keeps none."""
        return read_meshes(self._run) if (self._run / MESHES).is_file() else {}

    @property
    def crop(self) -> CropConfig:
        """How objects are cut out, and how much must be seen of them."""
        return self._runner.config.crop

    @property
    def point_count(self) -> int:
        """How many points of each object the network reads."""
        return self._runner.config.network.points.count

    @property
    def min_visible(self) -> LeastVisible:
        """Which targets of a dataset are estimated."""
        return self.crop.min_visible

    @property
    def reads_rgb(self) -> bool:
        """Whether images need colour."""
        return self._runner.config.network.reads_rgb

    @property
    def stages_used(self) -> PredictConfig:
        """The settings with the stages that it chose."""
        return self.config

    def cut(self, image: RgbdImage) -> list[Crop]:
        """Return the crops of the detections that show enough; one of an unknown model as each object.

        Raises:
            InputError: A detection is of an object that the estimator does not know, or colour is missing.
        """
        if image.rgb is None and self.reads_rgb:
            raise InputError(
                f"{self._runner.config.estimator} reads colour, but the image has no rgb; "
                "datasets have it with rgb among --outputs"
            )
        found = list[Crop]()
        for position, item in enumerate(image.detections):
            numbers = [shape.obj_id for shape in may_be(item, self.objects)]
            crop = self._cut_one(image, position, item, numbers[0])
            if crop is not None:
                found += [replace(crop, obj_id=number) for number in numbers]
        return found

    def _has_surfaces(self) -> bool:
        return (self._run / MESHES).is_file() and not without_mesh(self._run, self.objects)

    def _refiner(self, run: Path) -> IcpRefiner | VerificationRefiner:
        if lacking := without_mesh(run, self.objects):
            raise TrainingError(
                f"{run} has no CAD surface of {', '.join(lacking)}, which ICP needs; predict with another --refine"
            )
        grazing = _FLIGHT_GRAZING if self.config.time_of_flight else self.config.icp.grazing
        if self.config.refine == "icp":
            return IcpRefiner(read_meshes(run), replace(self.config.icp, grazing=grazing), self.config.seed)
        groups = {item.obj_id: SymmetryGroup(np.reshape(item.symmetries, (-1, 4, 4))) for item in self.objects}
        return VerificationRefiner(read_meshes(run), groups, FitConfig().believing(grazing), self.config.seed)

    def _choose(self, candidates: Candidates, crops: Sequence[ObjectPoints]) -> Transforms:
        rows = [self._row[crop.obj_id] for crop in crops]
        return select_poses(candidates, self._symmetries.rows(rows), self._diameters[rows], self.config.way[0])

    def _verify(self, T_camera_object: Transform, crop: ObjectPoints, confidence: float) -> Verdict:
        curve, diameter = self.calibration, self.objects[self._row[crop.obj_id]].diameter
        if curve is None:
            return Verdict(confidence)
        return Verdict(confidence, curve.error_at(confidence) * diameter, curve.bound_at(confidence) * diameter)

    def _agree(
        self, T_camera_object: Transforms, crops: Sequence[ObjectPoints], proposals: Proposals
    ) -> list[Agreement]:
        symmetries = self._symmetries.rows([self._row[crop.obj_id] for crop in crops])
        return agreement(proposals.candidates, symmetries, T_camera_object)

    def _cut_one(self, image: RgbdImage, position: int, detection: Detection, obj_id: int) -> Crop | None:
        number = detection.number_at(position)
        rng = np.random.default_rng([self.config.seed, image.scene_id, image.image_id, number])
        label = CropLabel(image.scene_id, image.image_id, position, obj_id, np.eye(4), image.gravity)
        mask = detection.pixels(*image.depth.shape)
        crop = cut_mask(image.camera, label, mask, image.depth, image.rgb, self.crop, rng)
        if crop is None or self.config.refine != "verify":
            return crop
        points = masked_points(image, mask, np.random.default_rng([self.config.seed, number]))
        return replace(crop, view=DepthView(image.camera, image.depth, mask, points, image.gravity))
