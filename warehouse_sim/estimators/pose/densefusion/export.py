"""A trained network as an ONNX file: proposals and one refiner pass, for programs without torch."""

import json
from pathlib import Path

import torch
from torch import Tensor, nn

from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusion
from warehouse_sim.estimators.pose.densefusion.networks.interface import NetworkInput
from warehouse_sim.estimators.pose.densefusion.networks.rotations import matrix_from_quat_wxyz
from warehouse_sim.estimators.pose.densefusion.run_config import PoseRun
from warehouse_sim.learning.onnx_file import export_network

OUTPUTS = ("rotations", "translations", "confidences", "rotation", "translation")
"""Proposals (b m 3 3), (b m 3), (b m), and the most confident one after one refiner pass (b 3 3), (b 3)."""
TOLERANCE = 1e-4
"""Largest difference from torch that is accepted, in rotation matrices, confidences and half diameters."""
_TRACED, _CHECKED = 2, 5


class PortableNetwork(nn.Module):
    """A network whose inputs and outputs are plain tensors; lengths are normalised as those of ``NetworkInput``.

    Args:
        network: A trained network.
    """

    def __init__(self, network: DenseFusion) -> None:
        super().__init__()
        self.network = network

    def forward(
        self,
        points: Tensor,
        pixel: Tensor,
        class_index: Tensor,
        rgb: Tensor | None = None,
        depth: Tensor | None = None,
        inside: Tensor | None = None,
        level: Tensor | None = None,
    ) -> tuple[Tensor, ...]:
        """Return what ``OUTPUTS`` names."""
        inputs = NetworkInput(points, pixel, class_index, rgb, depth, inside, level)
        embedding = self.network.embed(inputs)
        proposal = self.network.propose(inputs, embedding)
        found = proposal.hypotheses
        rotation, translation = self.network.refine(*found.most_confident(), inputs, embedding, proposal)
        rotations = matrix_from_quat_wxyz(found.quat_wxyz)
        return rotations, found.translation, torch.sigmoid(found.logit), rotation, translation


def export_onnx(run: Path, out: Path) -> float:
    """Write the network of a run folder as an ONNX file with a free batch axis, and compare it with torch.

    The file's metadata say what is needed to prepare inputs and to read outputs: the objects in the order of the
    classes with their diameters (m), points an object, side of the crops.

    Args:
        run: Run folder, or folder of a bundled model.
        out: File to write.

    Returns:
        The largest difference from torch over a batch of random inputs.

    Raises:
        MissingPackageError: onnx, onnxscript or onnxruntime is not installed.
        TrainingError: The folder holds no complete run, or the file does not compute what torch computes.
    """
    config = PoseRun.read(run)
    network = PortableNetwork(config.load_network(run)).eval()
    examples = random_inputs(config, _TRACED), random_inputs(config, _CHECKED)
    return export_network(network, examples, OUTPUTS, _metadata(config), out, TOLERANCE)


def random_inputs(config: PoseRun, batch: int, seed: int = 0) -> dict[str, Tensor]:
    """Return random inputs of a network by name, of the shapes and ranges that real ones have."""
    generator = torch.Generator().manual_seed(seed)
    network, side = config.network, config.network.side_px or 1
    count = network.points.count
    inputs = {
        "points": torch.randn((batch, count, 3), generator=generator) * 0.4,
        "pixel": torch.randint(0, side**2, (batch, count), generator=generator),
        "class_index": torch.randint(0, len(config.objects), (batch,), generator=generator),
    }
    if network.reads_rgb:
        inputs["rgb"] = torch.randint(0, 256, (batch, side, side, 3), generator=generator, dtype=torch.uint8)
    if network.reads_depth:
        ahead = torch.randn((batch, side, side), generator=generator).clamp(-3.0, 3.0)
        reading = torch.rand((batch, side, side), generator=generator) < 0.9
        inputs["depth"] = torch.stack([ahead * reading, reading.float()], dim=-1)
    if network.inliers is not None:
        inputs["inside"] = (torch.rand((batch, count), generator=generator) < 0.75).float()
    if network.upright:
        inputs["level"] = (torch.rand(batch, generator=generator) < 0.7).float()
    return inputs


def _metadata(config: PoseRun) -> dict[str, str]:
    objects = [{"obj_id": item.obj_id, "name": item.name, "diameter": item.diameter} for item in config.objects]
    return {
        "estimator": config.estimator,
        "objects": json.dumps(objects),
        "points": str(config.network.points.count),
        "side_px": str(config.network.side_px or 0),
        "units": "lengths about the median point, in half diameters of the object",
    }
