"""Several processes that train one network: each takes its share of every step, and all agree on the time."""

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

_PATIENCE = timedelta(hours=1)
"""How long processes wait for each other, of which one alone validates, before they give up."""


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
    def device(self) -> torch.device:
        """Where this process computes: on a GPU of its own where there are any."""
        return torch.device("cuda", self.rank) if torch.cuda.is_available() else torch.device("cpu")

    @property
    def share(self) -> slice:
        """The samples of a step that this process takes."""
        return slice(self.rank, None, self.world)


@contextmanager
def joined(place: Place) -> Iterator[None]:
    """Connect this process with the others of a training during the block."""
    if place.world == 1:
        yield
        return
    torch.distributed.init_process_group(
        "nccl" if place.device.type == "cuda" else "gloo",
        init_method=f"tcp://127.0.0.1:{place.port}",
        timeout=_PATIENCE,
        world_size=place.world,
        rank=place.rank,
    )
    try:
        yield
    finally:
        torch.distributed.destroy_process_group()


def agree_on_time(clock: Clock, place: Place, device: torch.device) -> None:
    """Let several processes go by the clock of rank 0, so that they end and change what they do at the same step."""
    if place.world == 1:
        return
    share = torch.tensor(clock.share_of_time(), dtype=torch.float64, device=device)
    torch.distributed.broadcast(share, 0)
    clock.agree(float(share))


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


def _run(work: Callable[..., None], *args: Any) -> None:
    end_with_parent()
    work(*args)


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
