"""What any training run leaves behind: its kind, weights, curves and result, and where its files lie."""

import json
import re
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, Self

import safetensors
import safetensors.torch
import yaml
from torch import Tensor, nn

from warehouse_sim.config import load_yaml, to_mapping
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import ConfigError, TrainingError
from warehouse_sim.learning.settings import LoopConfig
from warehouse_sim.one_writer import is_lock
from warehouse_sim.output import make_folder, write_bytes

CONFIG, WEIGHTS, LOG, CURVES, RESULT, CHECKPOINTS, EVENTS = (
    "config.yaml",
    "weights.safetensors",
    "train.log",
    "curves.csv",
    "result.json",
    "checkpoints",
    "tensorboard",
)
FIRST_KIND = "densefusion"
"""What a run folder is that does not say: the only kind there was before the key ``kind``."""


@dataclass(frozen=True)
class Source:
    """A dataset that was trained on, or weights of another run that training began with."""

    name: str
    """Name of the dataset's folder; bundled name or path of the run folder, as it was given."""
    sha256: str
    """Digest of the dataset's manifest.json, or of the weights."""


@dataclass(frozen=True, kw_only=True)
class RunConfig(ABC):
    """What defines a trained network but its weights, as ``config.yaml`` of its run folder; a family adds its own."""

    estimator: str
    """Registered name."""
    version: str
    """Version of warehouse-sim that trained it."""
    datasets: tuple[Source, ...]
    """The training data."""
    train: LoopConfig
    """How it was trained."""
    started_from: Source | None = None
    """Trained weights that it began with; none for fresh ones."""
    kind: str = ""
    """Family that opens the run."""

    @abstractmethod
    def make_network(self) -> nn.Module:
        """Return the network with fresh weights."""

    @classmethod
    def read(cls, run: Path) -> Self:
        """Read ``config.yaml`` of a run folder.

        Raises:
            TrainingError: The folder is no run folder, or one of another family.
        """
        if (kind := read_kind(run)) != cls.kind:
            raise TrainingError(f"{run} is a run of the kind {kind}, not {cls.kind}; use it with what trained it")
        try:
            return load_yaml(cls, run / CONFIG)
        except ConfigError as problem:
            raise TrainingError(f"{problem}; was the run made by another version of warehouse-sim?") from problem

    def write(self, run: Path) -> None:
        """Write ``config.yaml``; what was trained comes before how."""
        plain = to_mapping(self)
        last = {name: plain.pop(name) for name in ("train", "started_from", "kind")}
        text = yaml.safe_dump(plain | last, sort_keys=False, default_flow_style=None, width=110)
        write_bytes(run / CONFIG, text.encode(), durable=True)

    def load_network(self, run: Path) -> Any:
        """Return the trained network of a run folder, ready for inference.

        Raises:
            TrainingError: The run has no weights yet, or they do not fit its configuration.
        """
        network = self.make_network()
        try:
            network.load_state_dict(read_weights(run))
        except RuntimeError as problem:
            raise TrainingError(f"{run / WEIGHTS} does not fit {CONFIG}: {' '.join(str(problem).split())}") from problem
        return network.eval()


def dataset_sources(readers: Sequence[DatasetReader]) -> tuple[Source, ...]:
    """Return what says which datasets are trained on."""
    return tuple(Source(reader.root.resolve().name, reader.digest) for reader in readers)


def package_version() -> str:
    """Return the version of warehouse-sim that trains."""
    try:
        return version("warehouse-sim")
    except PackageNotFoundError:
        return "not installed"


def read_kind(run: Path) -> str:
    """Return which family of estimators a run folder belongs to: the key ``kind`` of its ``config.yaml``.

    Raises:
        TrainingError: The folder is no run folder, or of no named estimator.
    """
    if not (run / CONFIG).is_file():
        raise TrainingError(f"{run} is not a run folder: it has no {CONFIG}; train an estimator with --out {run}")
    text = (run / CONFIG).read_text(encoding="utf-8", errors="replace")
    if re.search(r"""^estimator: *(''|""|null|~)? *$""", text, re.MULTILINE):
        raise TrainingError(f"{run / CONFIG}: estimator names none; it is the name that the run was trained by")
    found = re.search(r"^kind: *(\S+) *$", text, re.MULTILINE)
    return found.group(1) if found else FIRST_KIND


def claim_folder(run: Path, resume: bool) -> bool:
    """Make the folder of a run, and return whether it holds one to go on with.

    Raises:
        TrainingError: It holds a complete run, or anything at all unless ``resume``.
        OutputError: It cannot be made.
    """
    if resume and (run / RESULT).is_file():
        raise TrainingError(f"{run} is complete, there is nothing to resume; choose another folder to train again")
    if resume and (run / CONFIG).is_file():
        return True
    make_folder(run)
    # A run that was stopped while it read has left nothing but its log.
    if any(path.name != LOG and not is_lock(path) for path in run.iterdir()):
        raise TrainingError(f"{run} is not empty; resume the run in it, or choose another folder")
    return False


def write_weights(run: Path, network: nn.Module) -> None:
    """Write the network's weights as safetensors."""
    tensors = {name: value.detach().cpu().contiguous() for name, value in network.state_dict().items()}
    write_bytes(run / WEIGHTS, safetensors.torch.save(tensors), durable=True)


def read_weights(run: Path) -> dict[str, Tensor]:
    """Return the weights of a run folder by name.

    Raises:
        TrainingError: The run has none yet, or the file is malformed.
    """
    if not (run / WEIGHTS).is_file():
        raise TrainingError(f"{run} has no {WEIGHTS}; finish the training with --resume")
    try:
        return safetensors.torch.load_file(run / WEIGHTS)
    except safetensors.SafetensorError as problem:
        raise TrainingError(f"{run / WEIGHTS} does not fit {CONFIG}: {' '.join(str(problem).split())}") from problem


def write_result(run: Path, result: dict[str, Any]) -> None:
    """Write ``result.json``; its presence means that the run is complete."""
    write_bytes(run / RESULT, (json.dumps(result, indent=1) + "\n").encode(), durable=True)
