"""Observations without a disk: made as they are taken, equal to those that are read back from files."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from itertools import count
from typing import Any

from warehouse_sim.dataset.streamed import as_stored
from warehouse_sim.generation.executor import Work, make_in_order
from warehouse_sim.generation.observe import observe_scene
from warehouse_sim.generation.recipe import Recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.processes import end_where_a_script_runs_again
from warehouse_sim.render import BACKENDS, open_renderer, require_drawn
from warehouse_sim.render.renderer import Renderer
from warehouse_sim.schema import Observation


@dataclass(frozen=True)
class _Job:
    """What a worker needs to make any scene of a stream."""

    recipe: Recipe
    seed: int
    backend: str
    backend_options: Mapping[str, Any] = field(default_factory=dict)


def stream(
    recipe: Recipe,
    seed: int = 0,
    workers: int = 1,
    start: int = 0,
    scenes: int | None = None,
    backend: str = "raster",
    backend_options: Mapping[str, Any] | None = None,
    apart: bool = False,
) -> Iterator[Observation]:
    """Yield the observations of a dataset in order, scene after scene, each array as files would hold it.

    Nothing is made before it is requested, but for what other workers make meanwhile: two scenes a worker at most are
    in memory. Number ``n`` is always the same: ``start=n`` goes on where a stream was left after ``n``.

    Args:
        recipe: Where scenes are sampled from.
        seed: Seed of the dataset, >= 0.
        workers: Processes, >= 1; 1 works in this one, unless ``apart``.
        start: Observations to leave out at the beginning, >= 0; those of the same scene are made all the same.
        scenes: Number of scenes; None = no end.
        backend: Render backend.
        backend_options: Options of the backend that are not its defaults.
        apart: Whether a single worker is a process of its own, which works on while this one trains.

    Raises:
        UnknownNameError: The backend is not registered.
        ValueError: ``start`` or ``workers`` is out of range.
        SettleError: A scene does not stand in any attempt.
        DatasetError: A depth does not fit into 16 bits of millimetres.
        RenderError: The backend does not draw what the recipe wants.
        WorkerError: A scene ended every worker that made it.
    """
    end_where_a_script_runs_again()
    BACKENDS.get(backend)
    if start < 0 or workers < 1:
        raise ValueError(f"start must be >= 0 and workers >= 1, found {start} and {workers}")
    require_drawn(recipe.sensors.wanted, backend, backend_options or {})
    per_scene = recipe.scene.observations_per_scene * len(recipe.paired_variants.names())
    job = _Job(recipe, seed, backend, backend_options or {})
    first, skipped = divmod(start, per_scene)
    indices = count(first) if scenes is None else range(first, scenes)
    return _observations(make_in_order(partial(_open_job, job), seed, indices, workers, apart), skipped)


def _observations(made: Iterator[tuple[int, list[Observation]]], skipped: int) -> Iterator[Observation]:
    for _, observations in made:
        yield from observations[skipped:]
        skipped = 0


def _make_scene(job: _Job, scene_index: int, renderer: Renderer) -> list[Observation]:
    prepared = prepare_scene(job.recipe, job.seed, scene_index)
    scene, variants, rig = prepared.scene, prepared.variants, job.recipe.sensors
    return [as_stored(item) for item in observe_scene(scene, rig, renderer, variants, caster=prepared.caster)]


@contextmanager
def _open_job(job: _Job) -> Iterator[Work]:
    with open_renderer(job.backend, **job.backend_options) as renderer:
        yield lambda index: _make_scene(job, index, renderer)
