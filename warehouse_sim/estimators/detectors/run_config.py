"""What defines a trained detector but its weights, as ``config.yaml`` of its run folder."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import yaml

from warehouse_sim.config import load_yaml, to_mapping
from warehouse_sim.errors import ConfigError, TrainingError
from warehouse_sim.estimators.detectors.boxes import BoxNetwork
from warehouse_sim.estimators.detectors.settings import BoxTrainingConfig, DetectorConfig
from warehouse_sim.estimators.detectors.yolov5.network import DetectorNetwork, DetectorNetworkConfig
from warehouse_sim.estimators.images.settings import ImageConfig
from warehouse_sim.learning.run_folder import CONFIG, WEIGHTS, DatasetSource, StartingWeights, read_kind, read_weights
from warehouse_sim.output import write_bytes

KIND = "detector"
"""How run folders name this family."""


@dataclass(frozen=True)
class AnyRunConfig:
    """What defines a trained detector of any network."""

    estimator: str
    """Registered name."""
    version: str
    """Version of warehouse-sim that trained it."""
    datasets: tuple[DatasetSource, ...]
    """The training data."""
    classes: tuple[str, ...]
    """What it tells apart, in the order of the network's classes."""
    images: Any
    """What it reads."""
    network: Any
    """Sizes of the network."""
    train: BoxTrainingConfig
    """How it was trained."""
    started_from: StartingWeights | None = None
    """Trained weights that it began with; none for fresh ones."""
    kind: str = ""
    """Family that opens the run."""


@dataclass(frozen=True)
class RunConfig(AnyRunConfig):
    """Everything that defines a trained detector of this package but its weights."""

    images: ImageConfig
    """What it reads."""
    network: DetectorNetworkConfig
    """Sizes of the network."""
    train: DetectorConfig
    """How it was trained."""
    kind: str = KIND
    """Family that opens the run."""


Found = TypeVar("Found", bound=AnyRunConfig)
Network = TypeVar("Network", bound=BoxNetwork)


def write_config(run: Path, config: AnyRunConfig) -> None:
    """Write ``config.yaml``."""
    text = yaml.safe_dump(to_mapping(config), sort_keys=False, default_flow_style=None, width=110)
    write_bytes(run / CONFIG, text.encode(), durable=True)


def read_config(run: Path) -> RunConfig:
    """Read ``config.yaml`` of a run folder.

    Raises:
        TrainingError: The folder is no run folder, or one of another family.
    """
    return read_run_config(run, RunConfig, KIND)


def read_run_config(run: Path, config: type[Found], wanted: str) -> Found:
    """Read ``config.yaml`` of a run folder of the kind ``wanted``.

    Raises:
        TrainingError: The folder is no run folder, or one of another family.
    """
    if (kind := read_kind(run)) != wanted:
        raise TrainingError(f"{run} is a run of the kind {kind}, not {wanted}; it holds no such detector")
    try:
        return load_yaml(config, run / CONFIG)
    except ConfigError as problem:
        raise TrainingError(f"{problem}; was the run made by another version of warehouse-sim?") from problem


def load_network(run: Path, config: RunConfig) -> DetectorNetwork:
    """Return the trained network of a run folder, ready for inference.

    Raises:
        TrainingError: The run has no weights yet, or they do not fit its configuration.
    """
    return with_weights(DetectorNetwork(config.network, config.images), run)


def with_weights(network: Network, run: Path) -> Network:
    """Return a network with the weights of a run folder, ready for inference.

    Raises:
        TrainingError: The run has no weights yet, or they do not fit its configuration.
    """
    try:
        network.load_state_dict(read_weights(run))
    except RuntimeError as problem:
        raise TrainingError(f"{run / WEIGHTS} does not fit {CONFIG}: {' '.join(str(problem).split())}") from problem
    return network.eval()
