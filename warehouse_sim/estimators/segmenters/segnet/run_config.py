"""What defines a trained segmenter but its weights, as ``config.yaml`` of its run folder."""

from dataclasses import dataclass
from pathlib import Path

import yaml

from warehouse_sim.config import load_yaml, to_mapping
from warehouse_sim.errors import ConfigError, TrainingError
from warehouse_sim.estimators.segmenters.segnet.network import SegmenterNetwork, SegmenterNetworkConfig
from warehouse_sim.estimators.segmenters.segnet.settings import BoxCropConfig, SegmenterConfig
from warehouse_sim.learning.run_folder import CONFIG, WEIGHTS, DatasetSource, StartingWeights, read_kind, read_weights
from warehouse_sim.output import write_bytes

KIND = "segmenter"
"""How run folders name this family."""


@dataclass(frozen=True)
class KnownFaces:
    """An object whose key points are known: size and pockets say where they are."""

    obj_id: int
    name: str
    class_name: str
    points: tuple[tuple[float, ...], ...]
    """Of each side with pockets, six points one after the other (m, object frame)."""
    known: tuple[tuple[bool, ...], ...]
    """Which of the six each side has."""


@dataclass(frozen=True)
class RunConfig:
    """Everything that defines a trained segmenter but its weights."""

    estimator: str
    """Registered name."""
    version: str
    """Version of warehouse-sim that trained it."""
    datasets: tuple[DatasetSource, ...]
    """The training data."""
    objects: tuple[KnownFaces, ...]
    """What was trained on and has pockets."""
    crop: BoxCropConfig
    """How boxes are cut out."""
    network: SegmenterNetworkConfig
    """Sizes of the network."""
    train: SegmenterConfig
    """How it was trained."""
    started_from: StartingWeights | None = None
    """Trained weights that it began with; none for fresh ones."""
    kind: str = KIND
    """Family that opens the run."""


def write_config(run: Path, config: RunConfig) -> None:
    """Write ``config.yaml``."""
    text = yaml.safe_dump(to_mapping(config), sort_keys=False, default_flow_style=None, width=110)
    write_bytes(run / CONFIG, text.encode(), durable=True)


def read_config(run: Path) -> RunConfig:
    """Read ``config.yaml`` of a run folder.

    Raises:
        TrainingError: The folder is no run folder, or one of another family.
    """
    if (kind := read_kind(run)) != KIND:
        raise TrainingError(f"{run} is a run of the kind {kind}, not {KIND}; it holds no segmenter")
    try:
        return load_yaml(RunConfig, run / CONFIG)
    except ConfigError as problem:
        raise TrainingError(f"{problem}; was the run made by another version of warehouse-sim?") from problem


def load_network(run: Path, config: RunConfig) -> SegmenterNetwork:
    """Return the trained network of a run folder, ready for inference.

    Raises:
        TrainingError: The run has no weights yet, or they do not fit its configuration.
    """
    network = SegmenterNetwork(config.network)
    try:
        network.load_state_dict(read_weights(run))
    except RuntimeError as problem:
        raise TrainingError(f"{run / WEIGHTS} does not fit {CONFIG}: {' '.join(str(problem).split())}") from problem
    return network.eval()
