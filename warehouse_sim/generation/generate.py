"""Many scenes become a dataset: in this process or in several, from the start or where a run was stopped."""

import json
import os
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from functools import cache
from multiprocessing import get_context
from pathlib import Path

from warehouse_sim.catalog import catalog_object
from warehouse_sim.config import to_mapping
from warehouse_sim.dataset.manifest import Manifest, package_versions
from warehouse_sim.dataset.split import split_scenes
from warehouse_sim.dataset.store import DatasetStore
from warehouse_sim.errors import DatasetError
from warehouse_sim.generation.observe import observe_scene
from warehouse_sim.generation.recipe import Recipe
from warehouse_sim.generation.scene import settled_scene
from warehouse_sim.render import BACKENDS, open_renderer
from warehouse_sim.render.renderer import Renderer
from warehouse_sim.schema import ObjectModel

ProgressCallback = Callable[[int, int], None]
"""Called with the number of finished scenes and of all scenes."""


@dataclass(frozen=True)
class GenerateConfig:
    """How a dataset is made; only ``scenes``, ``seed``, ``formats`` and ``backend`` decide its bytes."""

    scenes: int | None = None
    """Number of scenes, >= 1; the recipe's own number by default."""
    seed: int = 0
    """Seed of the dataset, >= 0."""
    formats: tuple[str, ...] = ("kitti", "bop")
    """Dataset formats to write."""
    backend: str = "raster"
    """Render backend."""
    workers: int = 1
    """Processes, >= 1; 1 works in this process."""
    resume: bool = False
    """Keep the finished scenes of an interrupted run."""


@dataclass(frozen=True)
class _Job:
    """What a worker needs to make any scene of a dataset."""

    recipe: Recipe
    manifest: Manifest
    root: Path
    backend: str


def generate(
    recipe: Recipe, out: Path, config: GenerateConfig, progress: ProgressCallback = lambda done, total: None
) -> Manifest:
    """Make the dataset folder ``out``; its manifest is written last.

    Args:
        recipe: Where scenes are drawn from.
        out: Folder to make; it must be empty unless ``config.resume``.
        config: Seed, number of scenes, formats, workers.
        progress: Told after each scene.

    Raises:
        UnknownNameError: A format or the backend is not registered.
        DatasetError: The folder holds something else, a format cannot hold the data, or a setting is out of range.
        SettleError: A scene does not stand in any attempt.
        RenderError: No renderer can be opened.
    """
    BACKENDS.get(config.backend)
    if config.workers < 1 or config.seed < 0:
        raise DatasetError(f"workers must be >= 1 and seed >= 0, found {config.workers} and {config.seed}")
    manifest = make_manifest(recipe, config)
    store = DatasetStore(out, manifest)
    store.begin(target_models(recipe), recipe.sensors.make_camera(), config.resume)
    pending, job = store.pending(), _Job(recipe, manifest, out, config.backend)
    progress(manifest.scenes - len(pending), manifest.scenes)
    make_scenes = _in_this_process(job, pending) if config.workers == 1 else _in_a_pool(job, pending, config.workers)
    for finished, _ in enumerate(make_scenes, start=manifest.scenes - len(pending) + 1):
        progress(finished, manifest.scenes)
    return store.finish()


def make_manifest(recipe: Recipe, config: GenerateConfig) -> Manifest:
    """Return the manifest of the dataset that ``recipe`` and ``config`` describe."""
    scenes = recipe.scenes if config.scenes is None else config.scenes
    return Manifest(
        seed=config.seed,
        scenes=scenes,
        observations_per_scene=recipe.scene.observations_per_scene,
        splits={name: indices for name, indices in split_scenes(scenes, recipe.split).items()},
        formats=tuple(config.formats),
        targets=recipe.scene.targets,
        # Through JSON, so that a manifest read back equals the one written.
        recipe=json.loads(json.dumps(to_mapping(recipe))),
        packages=package_versions(),
    )


def target_models(recipe: Recipe) -> list[ObjectModel]:
    """Return each geometry that a label of the recipe can name, once, in order of obj_id.

    Looks and wear of one geometry share its obj_id; the first name the recipe lists stands for it.
    """
    loads = recipe.scene.loads
    names = (*loads.pallets, *loads.cartons, *recipe.scene.traffic.objects)
    models = [catalog_object(name) for name in names]
    targets = {model.obj_id: model for model in reversed(models) if model.class_name in recipe.scene.targets}
    return [targets[obj_id] for obj_id in sorted(targets)]


def _make_scene(job: _Job, scene_index: int, renderer: Renderer) -> None:
    scene, report = settled_scene(job.recipe, job.manifest.seed, scene_index)
    observations = observe_scene(scene, job.recipe.sensors, renderer)
    store = DatasetStore(job.root, job.manifest)
    store.write_scene(scene, observations, to_mapping(report), renderer.description)


def _in_this_process(job: _Job, scene_indices: list[int]) -> Iterator[int]:
    if not scene_indices:
        return
    with open_renderer(job.backend) as renderer:
        for index in scene_indices:
            _make_scene(job, index, renderer)
            yield index


def _in_a_pool(job: _Job, scene_indices: list[int], workers: int) -> Iterator[int]:
    if not scene_indices:
        return
    # spawn: an OpenGL context does not survive a fork.
    with ProcessPoolExecutor(min(workers, len(scene_indices)), get_context("spawn"), _prepare_worker) as pool:
        futures = {pool.submit(_make_scene_in_worker, job, index): index for index in scene_indices}
        try:
            for future in as_completed(futures):
                future.result()
                yield futures[future]
        finally:
            pool.shutdown(wait=True, cancel_futures=True)


def _prepare_worker() -> None:
    # One thread a worker: more would only fight for the same processors.
    for variable in ("LP_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(variable, "1")


@cache
def _worker_renderer(backend: str) -> Renderer:
    """One renderer a process, for its whole life: contexts that come and go are what drivers leak."""
    return open_renderer(backend)


def _make_scene_in_worker(job: _Job, scene_index: int) -> None:
    _make_scene(job, scene_index, _worker_renderer(job.backend))
