"""A trained detector as an ONNX file: canvas in, boxes and scores of all cells out, before suppression."""

import json
from pathlib import Path

import torch
from torch import Tensor, nn

from warehouse_sim.estimators.detectors.boxes import BoxNetwork, BoxRun
from warehouse_sim.estimators.detectors.yolov5.network import DetectorRun
from warehouse_sim.estimators.images.encoding import CANONICAL_FOCAL_PX
from warehouse_sim.estimators.images.letterbox import Letterbox
from warehouse_sim.learning.onnx_file import Inputs, export_network

OUTPUTS = ("boxes", "scores")
"""Edges on the canvas (b n 4, px) and the score of each class (b n c, 0-1)."""
TOLERANCE = 5e-2
"""Largest difference from torch that is accepted, in pixels and scores."""


class PortableDetector(nn.Module):
    """A detector whose inputs and outputs are plain tensors.

    Args:
        network: A trained network.
    """

    def __init__(self, network: BoxNetwork) -> None:
        super().__init__()
        self.network = network

    def forward(self, rgb: Tensor | None = None, depth: Tensor | None = None) -> tuple[Tensor, Tensor]:
        """Return what ``OUTPUTS`` names, of uint8 (b h w 3) and canonical metres (b h w)."""
        return self.network.decode(self.network(rgb, depth))


def export_detector(run: Path, out: Path, opens: type[BoxRun] = DetectorRun) -> float:
    """Write the network of a run folder with a free batch axis, for images of the shape of ``input_wh``.

    Args:
        run: Run folder.
        out: File to write.
        opens: What reads the run folder: of any network that gives boxes.

    Raises:
        MissingPackageError: onnx, onnxscript, onnxruntime or the network's library is not installed.
        TrainingError: The folder holds no complete run, or the file does not compute what torch computes.
    """
    config = opens.read(run)
    network = PortableDetector(config.load_network(run)).eval()
    return export_network(
        network, (_random_inputs(config, 2), _random_inputs(config, 3)), OUTPUTS, _metadata(config), out, TOLERANCE
    )


def _random_inputs(config: BoxRun, batch: int) -> Inputs:
    generator = torch.Generator().manual_seed(0)
    width, height = Letterbox.fit(config.images.input_wh, config.images.input_wh).size_wh
    inputs: Inputs = {}
    if "rgb" in config.images.reads:
        inputs["rgb"] = torch.randint(0, 256, (batch, height, width, 3), generator=generator, dtype=torch.uint8)
    if "depth" in config.images.reads:
        inputs["depth"] = 20.0 * torch.rand((batch, height, width), generator=generator)
    return inputs


def _metadata(config: BoxRun) -> dict[str, str]:
    return {
        "detector": config.estimator,
        "classes": json.dumps(config.classes),
        "size_wh": json.dumps(Letterbox.fit(config.images.input_wh, config.images.input_wh).size_wh),
        "depth": f"metres times {CANONICAL_FOCAL_PX:g} over the focal length on the canvas (px), 0 = no reading",
        "layout": "the image scaled evenly into the upper left of the canvas; boxes are edges on the canvas (px)",
    }
