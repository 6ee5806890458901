"""Run a trained network on crops: tensors stay in here, arrays come out."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, cast

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from warehouse_sim.estimators.chain import ObjectPoints, Proposals
from warehouse_sim.estimators.pose.choose import Candidates
from warehouse_sim.estimators.pose.densefusion.crops import Crop, stack_crops
from warehouse_sim.estimators.pose.densefusion.crops.batch import Batch, draw_batch
from warehouse_sim.estimators.pose.densefusion.run_config import RunConfig, load_network, read_config
from warehouse_sim.geometry.pose import Transforms, make_transform
from warehouse_sim.learning.threads import SMALL, cpu_threads


@dataclass(frozen=True, eq=False)
class NetworkProposals:
    """What a network proposes for b objects, and what its refiner needs."""

    candidates: Candidates
    batch: Batch
    """The network's input."""
    embedding: Float[Tensor, "b n e"] | None
    """What the images say at the points."""


class Runner:
    """A trained network, ready to propose and refine poses.

    Args:
        run: Run folder.
        device: Where it runs; "auto" takes a GPU if there is one.
        threads: Processor threads; None takes one for small networks, and torch's own number for large ones.

    Raises:
        TrainingError: The folder holds no complete run.
    """

    def __init__(self, run: Path, device: Literal["auto", "cpu", "cuda"] = "auto", threads: int | None = None) -> None:
        self.config: RunConfig = read_config(run)
        chosen = ("cuda" if torch.cuda.is_available() else "cpu") if device == "auto" else device
        self._device = torch.device(chosen)
        self._network = load_network(run, self.config).to(self._device)
        small = sum(parameter.numel() for parameter in self._network.parameters()) < SMALL
        self._threads = threads or (1 if small else None)

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
        # The first points, which lie in random order: an object is estimated the same in every batch.
        batch = draw_batch(stacked, index, self.config.network.points.count, None)
        embedding = self._network.embed(batch.inputs)
        found = self._network.propose(batch.inputs, embedding).hypotheses
        translation = found.translation * batch.scale[:, None, None] + batch.centre[:, None]
        candidates = Candidates(_array(found.quat_wxyz), _array(translation), _array(torch.sigmoid(found.logit)))
        return NetworkProposals(candidates, batch, embedding)

    def _refine(self, proposals: NetworkProposals, T_camera_object: Transforms) -> Transforms:
        batch, T = proposals.batch, torch.from_numpy(T_camera_object).float().to(self._device)
        rotation, translation = T[:, :3, :3], (T[:, :3, 3] - batch.centre) / batch.scale[:, None]
        for _ in range(self.config.train.refiner_iterations):
            rotation, translation = self._network.refine(rotation, translation, batch.inputs, proposals.embedding)
        return make_transform(_array(rotation), _array(translation * batch.scale[:, None] + batch.centre))


def _array(tensor: Tensor) -> np.ndarray:
    return tensor.double().cpu().numpy()
