"""Train a detector on dataset folders and leave a run folder."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from pathlib import Path

import torch
from torch import nn

from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.detectors.preparation import Prepared, network_config, prepare
from warehouse_sim.estimators.detectors.run_config import AnyRunConfig, RunConfig, read_config, write_config
from warehouse_sim.estimators.detectors.settings import AnyDetectorConfig, BoxTrainingConfig, DetectorConfig
from warehouse_sim.estimators.detectors.task import BoxTask, DetectionTask
from warehouse_sim.estimators.detectors.yolov5.network import DetectorNetwork
from warehouse_sim.estimators.images.order import GroupedOrder
from warehouse_sim.estimators.images.settings import Reads
from warehouse_sim.learning import run_folder
from warehouse_sim.learning.job import Watched, job_clock, job_threads, session_result, start_from, train_session
from warehouse_sim.learning.records import RunLog
from warehouse_sim.learning.run_folder import StartingWeights, package_version
from warehouse_sim.learning.settings import Progress
from warehouse_sim.resources import cache_folder


@dataclass(frozen=True, eq=False)
class StartedDetector:
    """What a training runs on."""

    task: BoxTask
    order: GroupedOrder
    prepared: Prepared
    config: AnyRunConfig
    """The resolved configuration."""


@dataclass(frozen=True)
class BoxJob(ABC):
    """What every process of a training must know, whatever network is trained."""

    name: str
    reads: Reads
    """Of images; nothing where these are none."""
    data: tuple[Path, ...]
    run: Path
    config: BoxTrainingConfig
    cache: Path | None

    @property
    @abstractmethod
    def is_small(self) -> bool:
        """Whether the network gains little from several threads."""

    @abstractmethod
    def read_old(self) -> AnyRunConfig:
        """Read the configuration of the run that is gone on with."""

    @abstractmethod
    def make(self, prepared: Prepared, order: GroupedOrder) -> tuple[BoxTask, AnyRunConfig]:
        """Return the training of a fresh network, and the resolved configuration."""

    def prepared(self, progress: Progress | None = None) -> Prepared:
        """Read the samples."""
        assert isinstance(self.config, AnyDetectorConfig)
        return prepare(self.reads, self.data, self.config, self.cache, progress)

    def start(self, progress: Progress | None = None) -> StartedDetector:
        """Read the samples and make a fresh network."""
        prepared = self.prepared(progress)
        torch.manual_seed(self.config.seed)
        sizes = [len(arrays["labels"]) for arrays in prepared.images["train"]]
        order = GroupedOrder(sizes, self.config.batch, self.config.seed)
        task, config = self.make(prepared, order)
        return StartedDetector(task, order, prepared, config)

    def begin_with(self, init: str | Path, network: nn.Module, log: RunLog) -> StartingWeights:
        """Copy weights that were trained before, and return what they were."""
        return start_from(init, network)


class DetectorJob(BoxJob):
    """A training of the detector of this package."""

    config: DetectorConfig

    @property
    def is_small(self) -> bool:
        """Whether the network gains little from several threads."""
        return self.config.size != "small"

    def read_old(self) -> RunConfig:
        """Read the configuration of the run that is gone on with."""
        return read_config(self.run)

    def make(self, prepared: Prepared, order: GroupedOrder) -> tuple[DetectionTask, RunConfig]:
        """Return the training of a fresh network with anchors for its data, and the resolved configuration."""
        sizes = network_config(prepared, self.config, self.config.size)
        network = DetectorNetwork(sizes, prepared.reading)
        task = DetectionTask(network, self.config, prepared.images, prepared.class_of, order)
        data, reading = prepared.datasets, prepared.reading
        config = RunConfig(self.name, package_version(), data, prepared.classes, reading, sizes, self.config)
        return task, config


def image_cache(cache: Path | None) -> Path | None:
    """Return the folder that keeps scaled images: ``cache``, one of the user's by default, none for "none"."""
    return cache_folder("images") if cache is None else (None if cache == Path("none") else cache)


def train_detector(
    job: BoxJob, resume: bool = False, progress: Progress | None = None, init: str | Path | None = None
) -> Path:
    """Train what a job describes; other arguments and errors are those of ``estimators.train.train``."""
    run, name = job.run, job.name
    old = job.read_old() if run_folder.claim_folder(run, resume) else None
    if old:
        _require_same(old, job)
        job = replace(job, config=old.train)
    log = RunLog(run / run_folder.LOG)
    names = ", ".join(map(str, job.data))
    log.note(f"{'resume' if old else 'train'} {name} {job.config.size} on {names}, torch {torch.__version__}")
    with job_threads(job):
        clock, started = job_clock(job), job.start(progress)
        _require_same_data(old, started.config, run, names)
        network = started.task.network
        if old:
            init = old.started_from.name if old.started_from else None
        write_config(run, replace(started.config, started_from=job.begin_with(init, network, log) if init else None))
        counts = {split: sum(len(part["labels"]) for part in parts) for split, parts in started.prepared.images.items()}
        log.note(", ".join(f"{count} images of {split}" for split, count in counts.items()))
        watched = Watched("val_ap50", "validation AP50 {:.1f} %")
        state = train_session(job, started, clock, log, watched, progress)
        result = session_result(state, network) | {f"{split}_images": count for split, count in counts.items()}
    run_folder.write_weights(run, network)
    run_folder.write_result(run, result)
    log.note(f"done: {result['samples']} samples in {result['seconds']} s on {result['device']}, {result['precision']}")
    return run


def _require_same(old: AnyRunConfig, job: BoxJob) -> None:
    if old.estimator != job.name:
        raise TrainingError(f"{job.run} is a run of {old.estimator}, not of {job.name}; choose another folder")
    if job.config not in (old.train, old.train.defaults()):
        raise TrainingError(f"{job.run} goes on with the settings in its {run_folder.CONFIG}; leave other settings out")


def _require_same_data(old: AnyRunConfig | None, new: AnyRunConfig, run: Path, names: str) -> None:
    if old and old.datasets != new.datasets:
        before = ", ".join(source.name for source in old.datasets)
        raise TrainingError(f"{run} was trained on other data ({before}) than {names}; resume with the same")
