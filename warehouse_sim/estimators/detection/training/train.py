"""Train a detector on dataset folders and leave a run folder."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import torch

from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.detection.networks.detector import DetectorNetwork
from warehouse_sim.estimators.detection.run_config import RunConfig, read_config, write_config
from warehouse_sim.estimators.detection.settings import DetectorConfig
from warehouse_sim.estimators.detection.training.preparation import Prepared, prepare
from warehouse_sim.estimators.detection.training.task import DetectionTask
from warehouse_sim.estimators.images.order import GroupedOrder
from warehouse_sim.estimators.images.settings import Reads
from warehouse_sim.estimators.images.warm_start import start_from
from warehouse_sim.learning import run_folder
from warehouse_sim.learning.progress import Progress
from warehouse_sim.learning.run_log import RunLog
from warehouse_sim.learning.session import Watched, job_clock, job_threads, session_result, train_session
from warehouse_sim.resources import cache_folder


@dataclass(frozen=True)
class DetectorJob:
    """What every process of a training must know."""

    name: str
    reads: Reads
    data: tuple[Path, ...]
    run: Path
    config: DetectorConfig
    cache: Path | None

    @property
    def is_small(self) -> bool:
        """Whether the network gains little from several threads."""
        return self.config.size != "small"

    def start(self, progress: Progress | None = None) -> "StartedDetector":
        """Read the samples and make a fresh network."""
        prepared = prepare(self.name, self.reads, self.data, self.config, self.cache, progress)
        torch.manual_seed(self.config.seed)
        network = DetectorNetwork(prepared.config.network, prepared.config.images)
        sizes = [len(arrays["labels"]) for arrays in prepared.images["train"]]
        order = GroupedOrder(sizes, self.config.batch, self.config.seed)
        task = DetectionTask(network, self.config, prepared.images, prepared.class_of, order)
        return StartedDetector(task, order, prepared)


@dataclass(frozen=True, eq=False)
class StartedDetector:
    """What a training runs on."""

    task: DetectionTask
    order: GroupedOrder
    prepared: Prepared


def train_detector(
    name: str,
    reads: Reads,
    data: Sequence[Path],
    run: Path,
    config: DetectorConfig,
    resume: bool = False,
    progress: Progress | None = None,
    init: str | Path | None = None,
    cache: Path | None = None,
) -> Path:
    """Train a detector that reads ``reads``; other arguments and errors are those of ``estimators.train.train``."""
    old = read_config(run) if run_folder.claim_folder(run, resume) else None
    if old:
        _require_same(old, name, config, run)
    kept = cache_folder("images") if cache is None else (None if cache == Path("none") else cache)
    job = DetectorJob(name, reads, tuple(data), run, old.train if old else config, kept)
    log = RunLog(run / run_folder.LOG)
    names = ", ".join(map(str, data))
    log.note(f"{'resume' if old else 'train'} {name} {job.config.size} on {names}, torch {torch.__version__}")
    with job_threads(job):
        clock, started = job_clock(job), job.start(progress)
        resolved = started.prepared.config
        if old and old.datasets != resolved.datasets:
            before = ", ".join(source.name for source in old.datasets)
            raise TrainingError(f"{run} was trained on other data ({before}) than {names}; resume with the same")
        network = started.task.network
        if old:
            init = old.started_from.name if old.started_from else None
        write_config(run, replace(resolved, started_from=start_from(init, network) if init else None))
        counts = {split: sum(len(part["labels"]) for part in parts) for split, parts in started.prepared.images.items()}
        log.note(", ".join(f"{count} images of {split}" for split, count in counts.items()))
        watched = Watched("val_ap50", "validation AP50 {:.1f} %")
        state = train_session(job, started, clock, log, watched, progress)
        result = session_result(state, network) | {f"{split}_images": count for split, count in counts.items()}
    run_folder.write_weights(run, network)
    run_folder.write_result(run, result)
    log.note(f"done: {result['samples']} samples in {result['seconds']} s on {result['device']}, {result['precision']}")
    return run


def _require_same(old: RunConfig, name: str, config: DetectorConfig, run: Path) -> None:
    if old.estimator != name:
        raise TrainingError(f"{run} is a run of {old.estimator}, not of {name}; choose another folder")
    if config not in (old.train, DetectorConfig(depth_source=old.train.depth_source)):
        raise TrainingError(f"{run} goes on with the settings in its {run_folder.CONFIG}; leave other settings out")
