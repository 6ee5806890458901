"""The scenes of a dataset on a Ray cluster: one task a scene, each stored as a shard of its own."""

import tempfile
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.shards.merge import merge
from warehouse_sim.dataset.shards.shard import Shard, pack_shard, packed_name, stored_shards, unpack_shard
from warehouse_sim.errors import WarehouseSimError, WorkerError
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import Recipe
from warehouse_sim.optional import require

ProgressCallback = Callable[[int, int], None]
_TRIES_AGAIN = 5
"""Nodes that one scene may lose."""
_LOOK_AGAIN = 5.0
"""So often (s) it is looked whether there is still a connection."""
_KEPT = "all else is kept: run it again"
_GONE = f"the connection to the Ray cluster is gone; {_KEPT}"


def generate_on_ray(
    recipe: Recipe,
    place: str,
    config: GenerateConfig,
    address: str | None = None,
    progress: ProgressCallback = lambda done, total: None,
) -> None:
    """Make every scene of a dataset that ``place`` does not hold yet, as ``shard-NNNNNN.tar``.

    A node that is lost costs the scenes that it was making; they are regenerated elsewhere. ``merge_packed`` makes the
    dataset of the archives.

    Args:
        recipe: Where scenes are sampled from.
        place: Folder of any file system that fsspec knows and all nodes reach.
        config: As for ``generate``; workers, resume and shard are not used.
        address: Of the cluster; None = the one that Ray is connected to, else a new one on this machine.
        progress: Called after each scene.

    Raises:
        MissingPackageError: Ray is not installed.
        WorkerError: Scenes could not be made, or the cluster is not reached any more; all others are kept, and are
            not regenerated.
    """
    ray = require("ray", "cluster", "to make scenes on a cluster")
    if not ray.is_initialized():
        try:
            ray.init(address=address, log_to_driver=False)
        except (ConnectionError, RuntimeError) as problem:
            raise WorkerError(f"the Ray cluster {address or ''} cannot be reached ({problem})") from problem
    total = recipe.scenes if config.scenes is None else config.scenes
    there = set(stored_shards(place))
    wanted = [index for index in range(total) if packed_name(index) not in there]
    task = ray.remote(num_cpus=1, max_retries=_TRIES_AGAIN)(_make_packed)
    waiting = {task.remote(recipe, place, config, Shard(index, total)): index for index in wanted}
    problems: list[str] = []
    progress(total - len(waiting), total)
    while waiting:
        done = _first_done(ray, list(waiting))
        index = waiting.pop(done)
        try:
            ray.get(done)
        except ray.exceptions.RayError as problem:
            problems.append(f"scene {index} of seed {config.seed}: {_last_line(problem)}")
        progress(total - len(waiting), total)
    if problems:
        raise WorkerError(f"{'; '.join(problems)}; {_KEPT}, or make one alone with --shard")


def _first_done(ray: ModuleType, waiting: list[Any]) -> Any:
    """Return the first task that ends.

    Raises:
        WorkerError: The connection is gone: Ray itself would wait forever, or begin a new cluster.
    """
    done: list[Any] = []
    while not done:
        try:
            done, _ = ray.wait(waiting, num_returns=1, timeout=_LOOK_AGAIN)
        except (ConnectionError, ray.exceptions.RaySystemError, SystemExit) as problem:
            # Ray ends the program, with 0, where its connection is closed while it waits.
            raise WorkerError(_GONE) from problem
        if not ray.is_initialized():
            raise WorkerError(_GONE)
    return done[0]


def merge_packed(
    place: str, out: Path, progress: ProgressCallback = lambda done, total: None, overwrite: bool = False
) -> Manifest:
    """Make the dataset folder ``out`` of the archives in ``place``: the bytes of a run on one machine.

    Args:
        place: As for ``generate_on_ray``.
        out: Folder to make; it must be empty unless ``overwrite``.
        progress: Called after each archive.
        overwrite: Remove the dataset that stands in ``out``.

    Raises:
        DatasetError: As ``merge``, or an archive cannot be read.
    """
    names = stored_shards(place)
    # Beside the result, so that files are linked and not copied.
    with tempfile.TemporaryDirectory(dir=out.resolve().parent, prefix=f".{out.name}.") as folder:
        parts = [Path(folder) / name for name in names]
        for name, part in zip(names, parts, strict=True):
            part.mkdir()
            unpack_shard(place, name, part)
        return merge(parts, out, progress=progress, overwrite=overwrite)


def _make_packed(recipe: Recipe, place: str, config: GenerateConfig, shard: Shard) -> None:
    """Make a shard on this node's own disk, and store it."""
    with ExitStack() as opened:
        folder = Path(opened.enter_context(tempfile.TemporaryDirectory(prefix="warehouse-sim-"))) / "shard"
        generate(recipe, folder, replace(config, workers=1, resume=False, shard=shard))
        pack_shard(folder, place, packed_name(shard.index))


def _last_line(problem: Any) -> str:
    cause = getattr(problem, "cause", None)
    text = str(cause if isinstance(cause, WarehouseSimError) else problem).strip()
    return text.splitlines()[-1] if text else type(problem).__name__
