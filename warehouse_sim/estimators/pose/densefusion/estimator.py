"""A trained network of the family as an estimator: crops, proposals, selection, its refiner, and ICP if configured.

The network runs in ``Runner``: tensors stay in there, arrays come out.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Literal, cast

import numpy as np
import torch
from jaxtyping import Bool, Float
from scipy.spatial import cKDTree
from torch import Tensor

from warehouse_sim.errors import InputError, TrainingError
from warehouse_sim.estimators.api import LeastVisible
from warehouse_sim.estimators.image import Detection, RgbdImage, require_rgb
from warehouse_sim.estimators.matching import kind_bonus, may_be
from warehouse_sim.estimators.pipeline import ObjectPoints, Pipeline, Proposals, Stages, Verdict
from warehouse_sim.estimators.pose.choose import Candidates, Symmetries, select_poses
from warehouse_sim.estimators.pose.densefusion.calibration import ErrorCurve, read_calibration
from warehouse_sim.estimators.pose.densefusion.crops.batch import Batch, sample_batch
from warehouse_sim.estimators.pose.densefusion.crops.crop_set import stack_crops
from warehouse_sim.estimators.pose.densefusion.crops.cut import Crop, CropLabel, cut_mask
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusion, PoseRun
from warehouse_sim.estimators.pose.densefusion.networks.interface import Proposal
from warehouse_sim.estimators.pose.densefusion.networks.rotations import multiply_quat_wxyz
from warehouse_sim.estimators.pose.densefusion.objects import MESHES, ObjectShape, read_meshes, without_mesh
from warehouse_sim.estimators.pose.densefusion.settings import CropConfig
from warehouse_sim.estimators.pose.fitting.hypotheses import masked_points
from warehouse_sim.estimators.pose.fitting.refiners import IcpRefiner, VerificationRefiner
from warehouse_sim.estimators.pose.fitting.search import FitConfig
from warehouse_sim.estimators.pose.fitting.verification import DepthView
from warehouse_sim.estimators.pose.icp.refine import IcpConfig
from warehouse_sim.estimators.pose.uncertainty.covariance import agreement
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import Transform, Transforms, make_transform, quat_wxyz_from_matrix
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.learning.compute import cpu_threads, place
from warehouse_sim.schema import Agreement


@dataclass(frozen=True, eq=False)
class NetworkProposals:
    """What a network proposes for b objects, and what its refiner needs."""

    candidates: Candidates
    batch: Batch
    """The network's input."""
    embedding: Float[Tensor, "b n e"] | None
    """What the images say at the points."""
    proposal: Proposal
    """What the network proposes, along the axes of its input."""

    def trusted(self, row: int, points: Float[np.ndarray, "p 3"]) -> Bool[np.ndarray, " p"]:
        """Return which points (camera frame, m) around an object the network takes for the object's.

        It has judged some of the crop's points; each other one goes with the nearest of them. A network that does not
        judge trusts all.
        """
        inliers, batch = self.proposal.inliers, self.batch
        if inliers is None:
            return np.ones(len(points), dtype=bool)
        judged = batch.inputs.points[row]
        if batch.turn is not None:
            judged = judged @ batch.turn[row]
        judged = judged * batch.scale[row] + batch.centre[row]
        nearest = cKDTree(_array(judged)).query(points)[1]
        trusted: Bool[np.ndarray, " p"] = _array(inliers.logit[row])[nearest] > 0.0
        return trusted


class Runner:
    """A trained network, ready to propose and refine poses.

    Args:
        run: Run folder.
        device: Where it runs; "auto" takes a GPU if there is one.
        threads: Processor threads; None takes one for small networks, and torch's own number for large ones.
        iterations: Corrections by the refiner; None for as many as in training.

    Raises:
        TrainingError: The folder holds no complete run.
    """

    def __init__(
        self,
        run: Path,
        device: Literal["auto", "cpu", "cuda"] = "auto",
        threads: int | None = None,
        iterations: int | None = None,
    ) -> None:
        self.config = PoseRun.read(run)
        self.iterations = self.config.train.refiner_iterations if iterations is None else iterations
        self._network: DenseFusion = self.config.load_network(run)
        self._device, self._threads = place(self._network, device, threads)

    @torch.inference_mode()
    def propose(self, crops: Sequence[ObjectPoints]) -> NetworkProposals:
        """Return the poses that the network proposes for each crop, in the camera frame."""
        with cpu_threads(self._threads):
            return self._propose(cast(Sequence[Crop], crops))

    @torch.inference_mode()
    def refine(self, T_camera_object: Transforms, crops: Sequence[ObjectPoints], proposals: Proposals) -> Transforms:
        """Return the poses (b 4 4) after the network's own corrections of what it proposed."""
        assert isinstance(proposals, NetworkProposals)
        with cpu_threads(self._threads):
            return self._refine(proposals, T_camera_object)

    def _propose(self, crops: Sequence[Crop]) -> NetworkProposals:
        stacked = stack_crops(crops, self.config.objects, self.config.crop).to(self._device)
        index = torch.arange(len(crops), device=self._device)
        config = self.config
        # The first points, which lie in random order: an object is estimated the same in every batch.
        batch = sample_batch(
            stacked, index, config.network.points.count, None, crop=config.crop, upright=config.network.upright
        )
        embedding = self._network.embed(batch.inputs)
        proposal = self._network.propose(batch.inputs, embedding)
        found = proposal.hypotheses
        shift, quat = found.translation * batch.scale[:, None, None], _array(found.quat_wxyz)
        if batch.turn is not None:
            # A row vector times R is R^T times the vector: back to the camera's axes.
            shift = shift @ batch.turn
            quat = _turned_back(quat, _array(batch.turn))
        translation = shift + batch.centre[:, None]
        candidates = Candidates(quat, _array(translation), _array(torch.sigmoid(found.logit)))
        return NetworkProposals(candidates, batch, embedding, proposal)

    def _refine(self, proposals: NetworkProposals, T_camera_object: Transforms) -> Transforms:
        batch, T = proposals.batch, torch.from_numpy(T_camera_object).float().to(self._device)
        rotation, translation = T[:, :3, :3], (T[:, :3, 3] - batch.centre) / batch.scale[:, None]
        if batch.turn is not None:
            rotation, translation = batch.turn @ rotation, (batch.turn @ translation[..., None])[..., 0]
        for _ in range(self.iterations):
            rotation, translation = self._network.refine(
                rotation, translation, batch.inputs, proposals.embedding, proposals.proposal
            )
        if batch.turn is not None:
            rotation, translation = batch.turn.mT @ rotation, (batch.turn.mT @ translation[..., None])[..., 0]
        return make_transform(_array(rotation), _array(translation * batch.scale[:, None] + batch.centre))


def _turned_back(quat_wxyz: Float[np.ndarray, "b m 4"], turn: Float[np.ndarray, "b 3 3"]) -> Float[np.ndarray, "b m 4"]:
    """Return the rotations before each object's turn."""
    before = np.stack([quat_wxyz_from_matrix(R.T) for R in turn])
    product = multiply_quat_wxyz(torch.from_numpy(before)[:, None], torch.from_numpy(quat_wxyz))
    return np.asarray(product.numpy())


def _array(tensor: Tensor) -> np.ndarray:
    return tensor.double().cpu().numpy()


_FLIGHT_GRAZING = 2.0
"""Power of the cosine by which time of flight is believed on level surfaces."""


class Estimator(Pipeline):
    """The stages of a run folder; batched over all objects of some images.

    Args:
        run: Run folder, or folder of a bundled model.
        config: Settings.

    Raises:
        TrainingError: The folder holds no complete run, or no CAD surfaces although ICP is requested.
        InputError: Corrections are requested of a refiner that was not trained.
    """

    def __init__(self, run: Path, config: PredictConfig = PredictConfig()) -> None:  # noqa: B008  frozen
        self._run = run
        fitted, requested = read_calibration(run), config.refiner_iterations
        iterations = fitted.refiner_iterations if requested is None else requested
        self._runner = Runner(run, config.device, config.threads, iterations)
        if requested and not self._runner.config.refines:
            raise InputError(
                f"{run.name} has no trained refiner, and --refiner-iterations {requested} would change nothing: leave "
                f"it out, or train one with warehouse-sim train {self._runner.config.estimator} --phase refiner "
                f"--init {run}"
            )
        has_surfaces = (run / MESHES).is_file() and not without_mesh(run, self.objects)
        self.config = config = config.with_stages(has_surfaces)
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
        if self.reads_rgb:
            require_rgb(image, self._runner.config.estimator)
        found = list[Crop]()
        for position, item in enumerate(image.detections):
            shapes = may_be(item, self.objects)
            crop = self._cut_one(image, position, item, shapes[0].obj_id)
            if crop is not None:
                found += [replace(crop, obj_id=shape.obj_id, bonus=kind_bonus(item, shape.name)) for shape in shapes]
        return found

    def _refiner(self, run: Path) -> IcpRefiner | VerificationRefiner:
        if lacking := without_mesh(run, self.objects):
            raise TrainingError(
                f"{run} has no CAD surface of {', '.join(lacking)}, which ICP needs; predict with another --refine"
            )
        grazing = _FLIGHT_GRAZING if self.config.time_of_flight else 0.0
        if self.config.refine == "icp":
            return IcpRefiner(read_meshes(run), IcpConfig(grazing=grazing), self.config.seed)
        groups = {item.obj_id: SymmetryGroup(np.reshape(item.symmetries, (-1, 4, 4))) for item in self.objects}
        return VerificationRefiner(read_meshes(run), groups, FitConfig(grazing=grazing), self.config.seed)

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
