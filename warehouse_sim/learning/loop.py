"""The loop that trains a network in one process, which may be one of several."""

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Generic, Protocol, TypeVar

import numpy as np
import torch
from jaxtyping import Float, Int
from torch import Tensor, nn
from torch.nn.parallel import DistributedDataParallel

from warehouse_sim.errors import TrainingError
from warehouse_sim.learning.checkpoint import MovingAverage, latest_checkpoint, load_checkpoint, save_checkpoint
from warehouse_sim.learning.clock import Clock, learning_rate_factor
from warehouse_sim.learning.compute import choose_precision, mixed, on_device
from warehouse_sim.learning.observer import Observer, TrainingState
from warehouse_sim.learning.parallel import Worker, process_group, synchronise_clock
from warehouse_sim.learning.samples.order import step_seed
from warehouse_sim.learning.settings import LoopConfig

Key = TypeVar("Key", bound=Hashable)
Made = TypeVar("Made")


class MadeAhead(Generic[Key, Made]):
    """What keys stand for, made by threads.

    What is made depends on its key alone, so that neither the number of threads nor a wrong guess of what comes next
    changes it: what was guessed and is not requested is thrown away.

    Args:
        make: Makes what a key stands for; called in several threads at once.
        workers: Threads; 1 makes everything when it is requested, in the thread that asks.
    """

    def __init__(self, make: Callable[[Key], Made], workers: int) -> None:
        self._make = make
        self._pool = ThreadPoolExecutor(workers, "sample") if workers > 1 else None
        self._begun: dict[Key, Future[Made]] = {}

    def take(self, keys: Sequence[Key], following: Sequence[Key] = ()) -> list[Made]:
        """Return what ``keys`` stand for, in their order, and begin to make what probably is requested next."""
        if self._pool is None:
            return [self._make(key) for key in keys]
        begun, self._begun = self._begun, {}
        futures = [begun.pop(key) if key in begun else self._pool.submit(self._make, key) for key in keys]
        for wrong in begun.values():
            wrong.cancel()
        made = [future.result() for future in futures]
        # Only now: while this step is waited for, nothing else shall take its threads.
        self._begun = {key: self._pool.submit(self._make, key) for key in following}
        return made


class Task(nn.Module, ABC):
    """What is trained: a network, its loss on some samples, and how its success is measured.

    Args:
        network: What is trained.
    """

    def __init__(self, network: nn.Module) -> None:
        super().__init__()
        self.network = network

    @abstractmethod
    def forward(self, index: Int[Tensor, " b"], part: slice, step: int, fraction: float) -> Float[Tensor, ""]:
        """Return the loss of a step.

        Args:
            index: Samples of the step.
            part: Those of them that this process takes.
            step: Steps done before this one.
            fraction: Fraction of the training that is over, 0-1.
        """

    @abstractmethod
    def validate(self, network: nn.Module) -> dict[str, float]:
        """Return how well ``network``, the average of the trained one, does on samples that are not trained on."""

    def move_samples(self, device: torch.device) -> None:
        """Move what samples are drawn from to a device."""

    def rate(self, fraction: float, step: int) -> float | None:
        """Return the factor on the learning rate of a step; None for one cosine over the whole run."""
        return None


class ComposedTask(Task, Generic[Key, Made]):
    """A task whose samples are composed by threads, those of the next step while the network works on this.

    Args:
        network: What is trained.
        workers: Threads; 1 composes in the training's own.
    """

    def __init__(self, network: nn.Module, workers: int) -> None:
        super().__init__(network)
        self._device = torch.device("cpu")
        self._samples = MadeAhead(self.compose, workers)

    @abstractmethod
    def compose(self, key: Key) -> Made:
        """Return the sample that a key stands for; called in several threads at once."""

    def move_samples(self, device: torch.device) -> None:
        """Remember where batches go; what they are composed of stays on the disk."""
        self._device = device

    def stacked(self, arrays: Sequence[np.ndarray]) -> Tensor:
        """Return arrays of one shape as a batch on the device."""
        return on_device(torch.from_numpy(np.stack(arrays)), self._device)


class Order(Protocol):
    """Which samples each step takes; the step alone decides, so that a resumed run goes on as it would have."""

    def indices(self, step: int) -> Int[Tensor, " b"]:
        """Return the samples of one step."""


def fit(
    task: Task,
    order: Order,
    config: LoopConfig,
    clock: Clock,
    run: Path,
    worker: Worker = Worker(),  # noqa: B008  frozen
    observers: Sequence[Observer] = (),
) -> TrainingState:
    """Train until the clock has run out, leave the task's network with the averaged weights, and return where it ended.

    Args:
        task: What is trained; processes of other rank than 0 get the weights of rank 0.
        order: Samples of each step.
        config: Settings.
        clock: Progress of the run.
        run: Run folder; a checkpoint in it is gone on from.
        worker: Which process this is; rank 0 alone validates and writes.
        observers: Notified of what happens; given in rank 0 only.

    Raises:
        TrainingError: The checkpoint cannot be read, or the training has diverged.
        OutputError: A checkpoint cannot be written.
    """
    with process_group(worker):
        loop = _Loop(task, order, config, clock, run, worker)
        loop.start(observers)
        while not loop.is_over():
            loop.train_stretch(observers)
            loop.finish_stretch(observers)
        for observer in observers:
            observer.on_end(loop.state)
        loop.apply_average()
    return loop.state


class _Loop:
    """One process's part of a training."""

    def __init__(self, task: Task, order: Order, config: LoopConfig, clock: Clock, run: Path, worker: Worker) -> None:
        self._task, self._order, self._config, self._run, self._worker = task, order, config, run, worker
        self._device = worker.device
        self.state = TrainingState(config, clock, self._device, choose_precision(config.precision))
        task.to(self._device)
        task.move_samples(self._device)
        self._forward = _shared(task, worker)
        # Rank 0's weights have arrived; the average begins with them.
        self._average = MovingAverage(task.network, config.ema)
        self._optimiser = torch.optim.AdamW(
            task.network.parameters(), lr=config.learning_rate, weight_decay=config.weight_decay, fused=True
        )

    def start(self, observers: Sequence[Observer]) -> None:
        """Go on from a checkpoint; else validate once, which tells how much time the last validation needs."""
        self.state.clock.start_training()
        if checkpoint := latest_checkpoint(self._run):
            load_checkpoint(checkpoint, self._task.network, self._average, self._optimiser, self.state)
            self._reserve()
        else:
            self._validate()
        for observer in observers:
            observer.on_start(self.state)

    def is_over(self) -> bool:
        """Return whether the last stretch is done: all of them, or the time is up; each run has one at least."""
        synchronise_clock(self.state.clock, self._worker, self._device)
        stretch = self.state.stretch
        return stretch >= self._config.validations or (stretch > 0 and self.state.fraction >= 1.0)

    def train_stretch(self, observers: Sequence[Observer]) -> None:
        """Take steps, at least one, until the next validation is due."""
        self._task.train()
        due = (self.state.stretch + 1) / self._config.validations
        while True:
            self._step()
            for observer in observers:
                observer.on_step(self.state)
            if self.state.fraction >= due:
                return

    def finish_stretch(self, observers: Sequence[Observer]) -> None:
        """Validate and keep a checkpoint, unless the training has diverged."""
        self.state.stretch += 1
        weights = self._task.network.state_dict().values()
        if not all(bool(values.isfinite().all()) for values in (self.state.last_loss, *weights)):
            raise self._diverged()
        self._validate()
        for observer in observers:
            observer.on_validation(self.state)
        if self._worker.rank == 0:
            save_checkpoint(self._run, self._task.network, self._average, self._optimiser, self.state)

    def apply_average(self) -> None:
        """Give the network its average for good."""
        self._task.network.load_state_dict(self._average.module.state_dict())

    def _step(self) -> None:
        state, config, network = self.state, self._config, self._task.network
        synchronise_clock(state.clock, self._worker, self._device)
        fraction = state.fraction
        factor = self._task.rate(fraction, state.step)
        if factor is None:
            factor = learning_rate_factor(fraction, state.step, config.warmup_steps)
        state.learning_rate = config.learning_rate * factor
        for group in self._optimiser.param_groups:
            group["lr"] = state.learning_rate
        # One stream a step, so that layers that drop at random do so in a resumed run as in an uninterrupted one.
        torch.manual_seed(step_seed(config.seed, state.step, config.devices, self._worker.rank))
        with mixed(state.precision, self._device):
            loss = self._forward(self._order.indices(state.step), self._worker.fraction, state.step, fraction)
        self._optimiser.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(network.parameters(), config.clip_norm)
        self._optimiser.step()
        state.step += 1
        state.last_loss = loss.detach()
        self._average.follow(network, state.step)

    def _validate(self) -> None:
        if self._worker.rank:
            return
        started = time.monotonic()
        self._average.eval()
        with torch.no_grad(), mixed(self.state.precision, self._device):
            try:
                self.state.metrics = self._task.validate(self._average.module)
            except np.linalg.LinAlgError as problem:  # of outputs that are no numbers
                raise self._diverged() from problem
        self.state.validation_seconds = time.monotonic() - started
        self._reserve()

    def _diverged(self) -> TrainingError:
        return TrainingError(
            f"{self._run}: by step {self.state.step} the network gives no finite numbers any more; train again with a "
            f"learning_rate below {self._config.learning_rate:g}"
        )

    def _reserve(self) -> None:
        # The last validation comes after the last step: keep its time, and some for writing the files.
        self.state.clock.reserve(1.0 + 1.2 * self.state.validation_seconds)


def _shared(task: Task, worker: Worker) -> nn.Module:
    """Return what computes the loss so that all processes have its mean gradient after ``backward``."""
    if worker.world_size == 1:
        return task
    on_gpu = worker.device.type == "cuda"
    if on_gpu:
        nn.SyncBatchNorm.convert_sync_batchnorm(task)
    # Some parts of a network may take no part in some steps.
    return DistributedDataParallel(task, [worker.rank] if on_gpu else None, find_unused_parameters=True)
