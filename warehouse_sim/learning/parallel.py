"""Several processes that train one network: each takes its fraction of every step, and all agree on the time."""

import multiprocessing
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import timedelta
from typing import Any

import torch

from warehouse_sim.errors import TrainingError
from warehouse_sim.learning.clock import Clock
from warehouse_sim.processes import end_with_parent

_TIMEOUT = timedelta(hours=1)
"""How long processes wait for each other, of which one alone validates, before they give up."""


@dataclass(frozen=True)
class Worker:
    """Which of several processes this one is."""

    rank: int = 0
    """0 is the process that was called; it alone writes files."""
    world_size: int = 1
    """Number of processes."""
    port: int = 0
    """Where rank 0 listens on this machine."""

    @property
    def device(self) -> torch.device:
        """Where this process computes: on a GPU of its own where there are any."""
        return torch.device("cuda", self.rank) if torch.cuda.is_available() else torch.device("cpu")

    @property
    def fraction(self) -> slice:
        """The samples of a step that this process takes."""
        return slice(self.rank, None, self.world_size)


@contextmanager
def process_group(worker: Worker) -> Iterator[None]:
    """Connect this process with the others of a training during the block."""
    if worker.world_size == 1:
        yield
        return
    torch.distributed.init_process_group(
        "nccl" if worker.device.type == "cuda" else "gloo",
        init_method=f"tcp://127.0.0.1:{worker.port}",
        timeout=_TIMEOUT,
        world_size=worker.world_size,
        rank=worker.rank,
    )
    try:
        yield
    finally:
        torch.distributed.destroy_process_group()


def synchronise_clock(clock: Clock, worker: Worker, device: torch.device) -> None:
    """Let several processes go by the clock of rank 0, so that they end and change what they do at the same step."""
    if worker.world_size == 1:
        return
    fraction = torch.tensor(clock.fraction_of_time(), dtype=torch.float64, device=device)
    torch.distributed.broadcast(fraction, 0)
    clock.agree(float(fraction))


@contextmanager
def start_workers(world_size: int, work: Callable[..., None], *args: Any) -> Iterator[Worker]:
    """Run ``work(worker, *args)`` in ``world_size`` - 1 more processes during the block; yield the worker of this one.

    Raises:
        TrainingError: Another process failed, or there are fewer GPUs than processes.
    """
    if world_size == 1:
        yield Worker()
        return
    if torch.cuda.is_available() and torch.cuda.device_count() < world_size:
        raise TrainingError(f"devices is {world_size}, but this machine has {torch.cuda.device_count()} GPUs")
    port = _free_port()
    # Forked processes would inherit threads and CUDA contexts that do not survive a fork.
    context = multiprocessing.get_context("spawn")
    others = [
        context.Process(target=_run, args=(work, Worker(rank, world_size, port), *args))
        for rank in range(1, world_size)
    ]
    try:
        for process in others:
            process.start()
        try:
            yield Worker(0, world_size, port)
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


def _run(work: Callable[..., None], *args: Any) -> None:
    end_with_parent()
    work(*args)


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
