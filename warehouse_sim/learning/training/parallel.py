"""Several processes that train one network: each takes its share of every step, and all agree on the time."""

import multiprocessing
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import lightning
import torch
from lightning.fabric.plugins.environments import LightningEnvironment
from torch import nn

from warehouse_sim.errors import TrainingError
from warehouse_sim.learning.training.clock import Clock
from warehouse_sim.processes import end_with_parent


@dataclass(frozen=True)
class Place:
    """Which of several processes this one is."""

    rank: int = 0
    """0 is the process that was called; it alone writes files."""
    world: int = 1
    """Number of processes."""
    port: int = 0
    """Where rank 0 listens on this machine."""

    @property
    def share(self) -> slice:
        """The samples of a step that this process takes."""
        return slice(self.rank, None, self.world)


class OneMachine(LightningEnvironment):
    """Tell Lightning that the processes exist already.

    Args:
        place: Which one this is.
    """

    def __init__(self, place: Place) -> None:
        super().__init__()
        self._place, self._main_port = place, place.port

    @property
    def creates_processes_externally(self) -> bool:
        """Say so."""
        return True

    @property
    def main_address(self) -> str:
        """Rank 0 listens on this machine only."""
        return "127.0.0.1"

    def local_rank(self) -> int:
        """Return the number of this process."""
        return self._place.rank

    def node_rank(self) -> int:
        """There is one machine."""
        return 0


class ActAsOne(lightning.Callback):
    """Let several processes take the steps that one would.

    All go by the clock of rank 0, so that they end, validate and change the loss at the same step. And as long as the
    refiner takes no part, its weights have no gradients: the exchange would leave zeros, which the optimiser counts.

    Args:
        clock: The clock of this process.
        refiner: The network's refiner.
        refiner_start: Share of the run after which it is trained.
    """

    def __init__(self, clock: Clock, refiner: nn.Module, refiner_start: float) -> None:
        self._clock, self._refiner, self._refiner_start = clock, refiner, refiner_start
        clock.agree(0.0)

    def on_train_batch_start(
        self, trainer: lightning.Trainer, pl_module: lightning.LightningModule, *_: object
    ) -> None:
        """Take over the time of rank 0, before anything of this step depends on it."""
        if self._clock.max_seconds is not None:
            share = torch.tensor(self._clock.share_of_time(), dtype=torch.float64, device=pl_module.device)
            torch.distributed.broadcast(share, 0)
            self._clock.agree(float(share))

    def on_before_optimizer_step(
        self, trainer: lightning.Trainer, pl_module: lightning.LightningModule, *_: object
    ) -> None:
        """Take the zeros away."""
        if self._clock.fraction(trainer.global_step) < self._refiner_start:
            self._refiner.zero_grad()


@contextmanager
def companions(world: int, work: Callable[..., None], *args: Any) -> Iterator[Place]:
    """Run ``work(place, *args)`` in ``world`` - 1 more processes during the block; yield the place of this one.

    Raises:
        TrainingError: Another process failed, or there are fewer GPUs than processes.
    """
    if world == 1:
        yield Place()
        return
    if torch.cuda.is_available() and torch.cuda.device_count() < world:
        raise TrainingError(f"devices is {world}, but this machine has {torch.cuda.device_count()} GPUs")
    port = _free_port()
    # Forked processes would inherit threads and CUDA contexts that do not survive a fork.
    context = multiprocessing.get_context("spawn")
    others = [context.Process(target=_run, args=(work, Place(rank, world, port), *args)) for rank in range(1, world)]
    try:
        for process in others:
            process.start()
        try:
            yield Place(0, world, port)
        except RuntimeError as problem:
            if any(process.exitcode for process in others):
                raise TrainingError("a process of the training failed; its own message is above") from problem
            raise
        for process in others:
            process.join()
        if any(process.exitcode for process in others):
            raise TrainingError("a process of the training failed; its own message is above")
    finally:
        for process in others:
            if process.is_alive():
                process.terminate()
        if torch.distributed.is_initialized():
            torch.distributed.destroy_process_group()


def _run(work: Callable[..., None], *args: Any) -> None:
    end_with_parent()
    work(*args)


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
