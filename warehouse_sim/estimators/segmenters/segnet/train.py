"""Train a segmenter on dataset folders and leave a run folder."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import torch

from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.images.settings import Reads
from warehouse_sim.estimators.segmenters.segnet.network import SegmenterNetwork
from warehouse_sim.estimators.segmenters.segnet.preparation import Prepared, prepare
from warehouse_sim.estimators.segmenters.segnet.run_config import RunConfig, read_config, write_config
from warehouse_sim.estimators.segmenters.segnet.settings import SegmenterConfig
from warehouse_sim.estimators.segmenters.segnet.task import SegmentationTask
from warehouse_sim.learning import run_folder
from warehouse_sim.learning.job import Watched, job_clock, job_threads, session_result, start_from, train_session
from warehouse_sim.learning.records import RunLog
from warehouse_sim.learning.samples.order import SampleOrder
from warehouse_sim.learning.settings import Progress
from warehouse_sim.resources import cache_folder


@dataclass(frozen=True)
class SegmenterJob:
    """What every process of a training must know."""

    name: str
    reads: Reads
    keypoints: bool
    data: tuple[Path, ...]
    run: Path
    config: SegmenterConfig
    cache: Path | None

    @property
    def is_small(self) -> bool:
        """Whether the network gains little from several threads."""
        return self.config.width <= 24

    def start(self, progress: Progress | None = None) -> "StartedSegmenter":
        """Read the samples and make a fresh network."""
        prepared = prepare(self.name, self.reads, self.keypoints, self.data, self.config, self.cache, progress)
        torch.manual_seed(self.config.seed)
        network = SegmenterNetwork(prepared.config.network)
        order = SampleOrder(len(prepared.rows["train"]), self.config.batch, self.config.seed)
        task = SegmentationTask(network, self.config, prepared.config.crop, prepared.rows, order)
        return StartedSegmenter(task, order, prepared)


@dataclass(frozen=True, eq=False)
class StartedSegmenter:
    """What a training runs on."""

    task: SegmentationTask
    order: SampleOrder
    prepared: Prepared


def train_segmenter(
    name: str,
    reads: Reads,
    keypoints: bool,
    data: Sequence[Path],
    run: Path,
    config: SegmenterConfig,
    resume: bool = False,
    progress: Progress | None = None,
    init: str | Path | None = None,
    cache: Path | None = None,
) -> Path:
    """Train a segmenter that reads ``reads``; other arguments and errors are those of ``estimators.train.train``."""
    old = read_config(run) if run_folder.claim_folder(run, resume) else None
    if old:
        _require_same(old, name, config, run)
    kept = cache_folder("images") if cache is None else (None if cache == Path("none") else cache)
    job = SegmenterJob(name, reads, keypoints, tuple(data), run, old.train if old else config, kept)
    log = RunLog(run / run_folder.LOG)
    names = ", ".join(map(str, data))
    log.note(f"{'resume' if old else 'train'} {name} on {names}, torch {torch.__version__}")
    with job_threads(job):
        clock, started = job_clock(job), job.start(progress)
        resolved, network = started.prepared.config, started.task.network
        if old and old.datasets != resolved.datasets:
            before = ", ".join(source.name for source in old.datasets)
            raise TrainingError(f"{run} was trained on other data ({before}) than {names}; resume with the same")
        if old:
            init = old.started_from.name if old.started_from else None
        write_config(run, replace(resolved, started_from=start_from(init, network) if init else None))
        counts = {split: len(rows) for split, rows in started.prepared.rows.items()}
        log.note(", ".join(f"{count} boxes of {split}" for split, count in counts.items()))
        watched = Watched("val_iou", "validation IoU {:.1f} %")
        state = train_session(job, started, clock, log, watched, progress)
        result = session_result(state, network) | {f"{split}_boxes": count for split, count in counts.items()}
    run_folder.write_weights(run, network)
    run_folder.write_result(run, result)
    log.note(f"done: {result['samples']} samples in {result['seconds']} s on {result['device']}, {result['precision']}")
    return run


def _require_same(old: RunConfig, name: str, config: SegmenterConfig, run: Path) -> None:
    if old.estimator != name:
        raise TrainingError(f"{run} is a run of {old.estimator}, not of {name}; choose another folder")
    if config not in (old.train, SegmenterConfig()):
        raise TrainingError(f"{run} goes on with the settings in its {run_folder.CONFIG}; leave other settings out")
