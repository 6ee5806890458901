"""What defines a trained RT-DETR but its weights, as ``config.yaml`` of its run folder."""

from dataclasses import dataclass
from pathlib import Path

from warehouse_sim.estimators.detectors.rtdetr.network import RtdetrNetwork, RtdetrNetworkConfig
from warehouse_sim.estimators.detectors.rtdetr.settings import RtdetrConfig
from warehouse_sim.estimators.detectors.run_config import AnyRunConfig, read_run_config, with_weights
from warehouse_sim.estimators.images.settings import ImageConfig

KIND = "rtdetr"
"""How run folders name this family."""


@dataclass(frozen=True)
class RtdetrRunConfig(AnyRunConfig):
    """Everything that defines a trained RT-DETR but its weights."""

    images: ImageConfig
    """What it reads."""
    network: RtdetrNetworkConfig
    """Sizes of the network."""
    train: RtdetrConfig
    """How it was trained."""
    kind: str = KIND
    """Family that opens the run."""


def read_config(run: Path) -> RtdetrRunConfig:
    """Read ``config.yaml`` of a run folder.

    Raises:
        TrainingError: The folder is no run folder, or one of another family.
    """
    return read_run_config(run, RtdetrRunConfig, KIND)


def load_network(run: Path, config: RtdetrRunConfig) -> RtdetrNetwork:
    """Return the trained network of a run folder, ready for inference.

    Raises:
        TrainingError: The run has no weights yet, or they do not fit its configuration.
        MissingPackageError: The library is not installed.
    """
    return with_weights(RtdetrNetwork(config.network, config.images), run)
