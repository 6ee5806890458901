"""Random inputs of the right shapes for any network of the family."""

import torch

from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusion, DenseFusionConfig
from warehouse_sim.estimators.pose.densefusion.networks.interface import GroundTruth, NetworkInput
from warehouse_sim.estimators.pose.densefusion.networks.rotations import matrix_from_quat_wxyz
from warehouse_sim.estimators.pose.densefusion.objects import ShapeTensors
from warehouse_sim.estimators.pose.densefusion.settings import Size
from warehouse_sim.estimators.registries import ESTIMATORS

BATCH, CLASSES = 2, 3


def made_input(config: DenseFusionConfig) -> NetworkInput:
    """A batch with what ``config`` reads and nothing else."""
    side, count = config.side_px or 1, config.points.count
    reading = torch.randint(0, 2, (BATCH, side, side, 1)).float()
    return NetworkInput(
        torch.randn(BATCH, count, 3) * 0.5,
        torch.randint(0, side * side, (BATCH, count)),
        torch.tensor([2, 0]),
        torch.randint(0, 256, (BATCH, side, side, 3), dtype=torch.uint8) if config.reads_rgb else None,
        torch.cat([torch.randn(BATCH, side, side, 1) * reading, reading], dim=-1) if config.reads_depth else None,
    )


def made_gt() -> GroundTruth:
    """True poses for the batch."""
    return GroundTruth(matrix_from_quat_wxyz(torch.randn(BATCH, 4)), torch.randn(BATCH, 3) * 0.2, torch.tensor([2, 0]))


def made_shapes() -> ShapeTensors:
    """Shapes without any symmetry."""
    return ShapeTensors(
        torch.randn(CLASSES, 4, 3) * 0.5,
        torch.eye(3).repeat(CLASSES, 1, 1, 1),
        torch.zeros(CLASSES, 1, 3),
        torch.randn(CLASSES, 20, 3) * 0.5,
        torch.full((CLASSES,), 0.7),
    )


def build(name: str, size: Size, paper: bool = False) -> tuple[DenseFusion, NetworkInput]:
    """An untrained network of a method, and inputs for it."""
    torch.manual_seed(0)
    config = ESTIMATORS.get(name).network(size, paper)
    return DenseFusion(config, CLASSES), made_input(config)
