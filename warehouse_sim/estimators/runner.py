"""Run a trained network on crops: tensors stay in here, arrays come out."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from warehouse_sim.learning.batch import Batch, draw_batch
from warehouse_sim.learning.crop_set import stack_crops
from warehouse_sim.learning.crops import Crop
from warehouse_sim.learning.rotations import matrix_from_quat_wxyz
from warehouse_sim.learning.run_folder import RunConfig, load_network, read_config


@dataclass(frozen=True, eq=False)
class Proposals:
    """What the points of k objects propose, n points each, in the camera frame."""

    rotations: Float[np.ndarray, "k n 3 3"]
    translations: Float[np.ndarray, "k n 3"]
    """Metres."""
    confidences: Float[np.ndarray, "k n"]
    """0-1."""
    batch: Batch
    """The network's input, for the refiner."""
    colour: Float[Tensor, "k n e"] | None
    """The colour embedding, for the refiner."""


class Runner:
    """A trained network, ready to propose and refine poses.

    Args:
        run: Run folder.

    Raises:
        TrainingError: The folder holds no complete run.
    """

    def __init__(self, run: Path) -> None:
        self.config: RunConfig = read_config(run)
        self._network = load_network(run, self.config)

    @torch.inference_mode()
    def propose(self, crops: Sequence[Crop], seed: int) -> Proposals:
        """Return one pose a point of each crop; ``seed`` decides which points are drawn."""
        stacked = stack_crops(crops, self.config.objects, self.config.crop)
        generator = torch.Generator().manual_seed(seed)
        batch = draw_batch(stacked, torch.arange(len(crops)), self.config.network.points.count, generator)
        colour = self._network.embed(batch.rgb, batch.pixel)
        found = self._network(batch.points, colour, batch.class_index)
        translations = found.translation * batch.scale[:, None, None] + batch.centre[:, None]
        rotations = matrix_from_quat_wxyz(found.quat_wxyz)
        return Proposals(
            rotations.double().numpy(),
            translations.double().numpy(),
            torch.sigmoid(found.logit).double().numpy(),
            batch,
            colour,
        )

    @torch.inference_mode()
    def refine(self, proposals: Proposals, T_camera_object: Float[np.ndarray, "k 4 4"]) -> Float[np.ndarray, "k 4 4"]:
        """Return the poses after the network's own corrections."""
        batch, T = proposals.batch, torch.from_numpy(T_camera_object).float()
        rotation = T[:, :3, :3]
        translation = (T[:, :3, 3] - batch.centre) / batch.scale[:, None]
        for _ in range(self.config.train.refiner_iterations):
            rotation, translation = self._network.refine(
                rotation, translation, batch.points, proposals.colour, batch.class_index
            )
        refined = np.tile(np.eye(4), (len(T), 1, 1))
        refined[:, :3, :3] = rotation.double().numpy()
        refined[:, :3, 3] = (translation * batch.scale[:, None] + batch.centre).double().numpy()
        return refined
