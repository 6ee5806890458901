"""What a training run leaves behind: weights, the resolved settings and what prediction needs of the objects."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import safetensors.torch
import yaml

from warehouse_sim.config import load_yaml, to_mapping
from warehouse_sim.errors import ConfigError, TrainingError
from warehouse_sim.learning.crops.config import CropConfig
from warehouse_sim.learning.networks.densefusion import DenseFusion, DenseFusionConfig
from warehouse_sim.learning.objects import ObjectShape
from warehouse_sim.learning.settings import TrainConfig
from warehouse_sim.output import write_bytes

CONFIG, WEIGHTS, LOG, CURVES, RESULT, CHECKPOINTS, EVENTS = (
    "config.yaml",
    "weights.safetensors",
    "train.log",
    "curves.csv",
    "result.json",
    "checkpoints",
    "tensorboard",
)


@dataclass(frozen=True)
class DatasetSource:
    """A dataset that was trained on."""

    name: str
    """Name of its folder."""
    sha256: str
    """Digest of its manifest.json."""


@dataclass(frozen=True)
class StartingWeights:
    """Weights of another run that training began with."""

    name: str
    """Bundled name or path of the run folder, as it was given."""
    sha256: str
    """Digest of its weights."""


@dataclass(frozen=True)
class RunConfig:
    """Everything that defines a trained estimator but its weights."""

    estimator: str
    """Registered name."""
    version: str
    """Version of warehouse-sim that trained it."""
    datasets: tuple[DatasetSource, ...]
    """The training data."""
    objects: tuple[ObjectShape, ...]
    """Known objects, in the order of the network's classes."""
    network: DenseFusionConfig
    """Sizes of the network."""
    crop: CropConfig
    """How targets are cut out."""
    train: TrainConfig
    """How it was trained."""
    started_from: StartingWeights | None = None
    """Trained weights that it began with; none for fresh ones."""


def write_config(run: Path, config: RunConfig) -> None:
    """Write ``config.yaml``."""
    text = yaml.safe_dump(to_mapping(config), sort_keys=False, default_flow_style=None, width=110)
    write_bytes(run / CONFIG, text.encode(), durable=True)


def read_config(run: Path) -> RunConfig:
    """Read ``config.yaml`` of a run folder.

    Raises:
        TrainingError: The folder is no run folder.
    """
    if not (run / CONFIG).is_file():
        raise TrainingError(f"{run} is not a run folder: it has no {CONFIG}; train an estimator with --out {run}")
    try:
        return load_yaml(RunConfig, run / CONFIG)
    except ConfigError as problem:
        raise TrainingError(f"{problem}; was the run made by another version of warehouse-sim?") from problem


def write_weights(run: Path, network: DenseFusion) -> None:
    """Write the network's weights as safetensors."""
    tensors = {name: value.detach().cpu().contiguous() for name, value in network.state_dict().items()}
    write_bytes(run / WEIGHTS, safetensors.torch.save(tensors), durable=True)


def load_network(run: Path, config: RunConfig) -> DenseFusion:
    """Return the trained network of a run folder, ready for inference.

    Raises:
        TrainingError: The run has no weights yet, or they do not fit its configuration.
    """
    if not (run / WEIGHTS).is_file():
        raise TrainingError(f"{run} has no {WEIGHTS}; finish the training with --resume")
    network = DenseFusion(config.network, len(config.objects))
    try:
        network.load_state_dict(safetensors.torch.load_file(run / WEIGHTS))
    except (RuntimeError, safetensors.SafetensorError) as problem:
        raise TrainingError(f"{run / WEIGHTS} does not fit {CONFIG}: {' '.join(str(problem).split())}") from problem
    return network.eval()


def write_result(run: Path, result: dict[str, Any]) -> None:
    """Write ``result.json``; its presence means that the run is complete."""
    write_bytes(run / RESULT, (json.dumps(result, indent=1) + "\n").encode(), durable=True)
