"""A trained segmenter as an ONNX file: crops of boxes in, a probability for each pixel and maps of key points out."""

import json
from pathlib import Path

import torch
from torch import Tensor, nn

from warehouse_sim.estimators.segmenters.segnet.network import SegmenterNetwork, SegmenterRun
from warehouse_sim.learning.onnx_file import Inputs, export_network

TOLERANCE = 1e-3
"""Largest difference from torch that is accepted, in probabilities and logits."""


class PortableSegmenter(nn.Module):
    """A segmenter whose outputs are plain tensors.

    Args:
        network: A trained network.
    """

    def __init__(self, network: SegmenterNetwork) -> None:
        super().__init__()
        self.network = network

    def forward(self, width_rad: Tensor, rgb: Tensor | None = None, depth: Tensor | None = None) -> tuple[Tensor, ...]:
        """Return the probability of each pixel (b h w), and logits of key points (b k h w) where there are any."""
        mask, points = self.network(rgb, depth, width_rad)
        return (torch.sigmoid(mask), points) if self.network.config.keypoints else (torch.sigmoid(mask),)


def export_segmenter(run: Path, out: Path) -> float:
    """Write the network of a run folder with a free batch axis, and return the largest difference from torch.

    Raises:
        MissingPackageError: onnx, onnxscript or onnxruntime is not installed.
        TrainingError: The folder holds no complete run, or the file does not compute what torch computes.
    """
    config = SegmenterRun.read(run)
    network = PortableSegmenter(config.load_network(run)).eval()
    outputs = ("mask", "points") if config.network.keypoints else ("mask",)
    examples = _random_inputs(config, 2), _random_inputs(config, 3)
    return export_network(network, examples, outputs, _metadata(config), out, TOLERANCE)


def _random_inputs(config: SegmenterRun, batch: int) -> Inputs:
    generator = torch.Generator().manual_seed(0)
    width, height = config.crop.crop_wh
    inputs: Inputs = {"width_rad": 0.1 + 0.3 * torch.rand(batch, generator=generator)}
    if "rgb" in config.network.reads:
        inputs["rgb"] = torch.randint(0, 256, (batch, height, width, 3), generator=generator, dtype=torch.uint8)
    if "depth" in config.network.reads:
        inputs["depth"] = 2.0 + 2.0 * torch.rand((batch, height, width), generator=generator)
    return inputs


def _metadata(config: SegmenterRun) -> dict[str, str]:
    return {
        "segmenter": config.estimator,
        "crop_wh": json.dumps(config.crop.crop_wh),
        "margin": str(config.crop.margin),
        "width_rad": "width of the crop (px of the image) over the focal length (px)",
    }
