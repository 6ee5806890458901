"""What defines a trained detector of sweeps but its weights, as ``config.yaml`` of its run folder."""

from dataclasses import dataclass
from pathlib import Path

from warehouse_sim.estimators.detectors.run_config import AnyRunConfig, read_run_config, with_weights
from warehouse_sim.estimators.detectors.yolov5.network import DetectorNetworkConfig
from warehouse_sim.estimators.lidar.sweep.network import SweepNetwork
from warehouse_sim.estimators.lidar.sweep.settings import RangeImageConfig, SweepDetectorConfig

KIND = "sweep-detector"
"""How run folders name this family."""


@dataclass(frozen=True)
class SweepRunConfig(AnyRunConfig):
    """Everything that defines a trained detector of sweeps but its weights."""

    images: RangeImageConfig
    """Which directions it sees."""
    network: DetectorNetworkConfig
    """Sizes of the network."""
    train: SweepDetectorConfig
    """How it was trained."""
    kind: str = KIND
    """Family that opens the run."""


def read_config(run: Path) -> SweepRunConfig:
    """Read ``config.yaml`` of a run folder.

    Raises:
        TrainingError: The folder is no run folder, or one of another family.
    """
    return read_run_config(run, SweepRunConfig, KIND)


def load_network(run: Path, config: SweepRunConfig) -> SweepNetwork:
    """Return the trained network of a run folder, ready for inference.

    Raises:
        TrainingError: The run has no weights yet, or they do not fit its configuration.
    """
    return with_weights(SweepNetwork(config.network, config.images), run)
