"""Run a trained network on crops: tensors stay in here, arrays come out."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, cast

import numpy as np
import torch
from jaxtyping import Bool, Float
from scipy.spatial import cKDTree
from torch import Tensor

from warehouse_sim.estimators.pipeline import ObjectPoints, Proposals
from warehouse_sim.estimators.pose.choose import Candidates
from warehouse_sim.estimators.pose.densefusion.crops.batch import Batch, sample_batch
from warehouse_sim.estimators.pose.densefusion.crops.crop_set import stack_crops
from warehouse_sim.estimators.pose.densefusion.crops.cut import Crop
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusion, PoseRun
from warehouse_sim.estimators.pose.densefusion.networks.interface import Proposal
from warehouse_sim.estimators.pose.densefusion.networks.rotations import multiply_quat_wxyz
from warehouse_sim.geometry.pose import Transforms, make_transform, quat_wxyz_from_matrix
from warehouse_sim.learning.compute import cpu_threads, place


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
