"""A trained detector of sweeps as an ONNX file: range image in, boxes, scores and pixels out, before suppression."""

import json
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn

from warehouse_sim.estimators.lidar.sweep.compose import MARGIN
from warehouse_sim.estimators.lidar.sweep.network import SweepNetwork, SweepRun
from warehouse_sim.learning.onnx_file import Inputs, export_network

OUTPUTS = ("boxes", "scores", "pixels")
"""Edges on the image with its margins (b n 4, px), the score of each class (b n c, 0-1), whether each pixel shows an
object (b h w, 0-1)."""
TOLERANCE = 5e-2
"""Largest difference from torch that is accepted, in pixels and scores."""


class PortableSweepDetector(nn.Module):
    """A detector of sweeps whose inputs and outputs are plain tensors.

    Args:
        network: A trained network.
    """

    def __init__(self, network: SweepNetwork) -> None:
        super().__init__()
        self.network = network

    def forward(self, range_m: Tensor, height_m: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Return what ``OUTPUTS`` names, of ranges (b h w, m, 0 = no reading) and heights (b h w, m, NaN = unknown)."""
        raw = self.network(None, torch.stack([range_m, height_m], dim=1))
        boxes, scores = self.network.decode(raw)
        return boxes, scores, torch.sigmoid(raw.pixels)


def export_sweep_detector(run: Path, out: Path) -> float:
    """Write the network of a run folder with a free batch axis, for whole turns with a margin at both ends.

    Raises:
        MissingPackageError: onnx, onnxscript or onnxruntime is not installed.
        TrainingError: The folder holds no complete run, or the file does not compute what torch computes.
    """
    config = SweepRun.read(run)
    network = PortableSweepDetector(config.load_network(run)).eval()
    return export_network(network, (_turns(config, 2), _turns(config, 3)), OUTPUTS, _metadata(config), out, TOLERANCE)


def _turns(config: SweepRun, batch: int) -> Inputs:
    generator = torch.Generator().manual_seed(0)
    shape = batch, config.images.rows, config.images.columns + 2 * MARGIN
    height = 4.0 * torch.rand(shape, generator=generator) - 0.5
    height[:, :, ::7] = np.nan
    return {"range_m": 30.0 * torch.rand(shape, generator=generator), "height_m": height}


def _metadata(config: SweepRun) -> dict[str, str]:
    low, high = config.images.elevation_deg
    return {
        "detector": config.estimator,
        "classes": json.dumps(config.classes),
        "size_wh": json.dumps([config.images.columns + 2 * MARGIN, config.images.rows]),
        "columns": f"{config.images.columns} of a turn, azimuth falling from 180 deg, ahead in the middle; "
        f"{MARGIN} of the other end are repeated before the first and after the last",
        "rows": f"elevation falling from {high:g} to {low:g} deg",
        "range_m": "nearest reading of a pixel, 0 = none",
        "height_m": "of that reading above the floor, NaN = unknown",
    }
