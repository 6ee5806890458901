"""Many scenes become a dataset: in this process or in several, from the start or where a run was stopped."""

import os
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from warehouse_sim.annotate.dockable import accessibility
from warehouse_sim.annotate.trucks import TRUCKS
from warehouse_sim.config import to_mapping
from warehouse_sim.dataset.discard import discard_dataset
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.store import DatasetStore
from warehouse_sim.dataset.stored.scene_record import Outcome, SceneRecord
from warehouse_sim.errors import OutputError
from warehouse_sim.generation.executor import Work, make_scenes
from warehouse_sim.generation.observe import observe_scene
from warehouse_sim.generation.plan import GenerateConfig, plan_dataset, storable
from warehouse_sim.generation.recipe import Recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.one_writer import one_writer
from warehouse_sim.processes import end_where_a_script_runs_again
from warehouse_sim.render import BACKENDS, open_renderer, require_drawn
from warehouse_sim.render.renderer import Renderer

_OBSERVATION_LIMIT_S = 600.0
"""What a try of a scene may take for each of its observations, by default."""
ProgressCallback = Callable[[int, int], None]
"""Called with the number of finished scenes and of all scenes."""


@dataclass(frozen=True)
class Job:
    """What a worker needs to make any scene of a dataset."""

    recipe: Recipe
    manifest: Manifest
    root: Path
    config: GenerateConfig


def generate(
    recipe: Recipe, out: Path, config: GenerateConfig, progress: ProgressCallback = lambda done, total: None
) -> Manifest:
    """Make the dataset folder ``out``; its manifest is written last, that of a shard by ``dataset.shards.merge`` alone.

    Args:
        recipe: Where scenes are sampled from.
        out: Folder to make; it must be empty unless ``config.resume`` or ``config.overwrite``.
        config: Seed, number of scenes, formats, workers.
        progress: Called after each scene.

    Raises:
        UnknownNameError: A format or the backend is not registered.
        DatasetError: The folder holds something else, a format cannot hold the data, or a setting is out of range.
        SettleError: A scene does not stand in any attempt, unless ``config.skip_failed``; its ``scenes`` names it.
        RenderError: No renderer can be opened, or it does not draw what the recipe wants.
        OutputError: Another process writes the folder, it cannot be written, or it would exceed ``config.max_gb``.
        WorkerError: Scenes ended every worker that made them, or took too long; all else is kept for
            ``config.resume``. With ``config.skip_failed``, more than a tenth of them did.
    """
    end_where_a_script_runs_again()
    BACKENDS.get(config.backend)
    require_drawn(recipe.sensors.wanted, config.backend, config.backend_options)
    plan = plan_dataset(recipe, config)
    manifest = plan.manifest
    limit_s = config.scene_limit_s or _OBSERVATION_LIMIT_S * manifest.observations_per_scene
    wanted = range(manifest.scenes) if config.shard is None else config.shard.scenes(manifest.scenes)
    skipped: list[int] = []
    skip = (lambda index, why: skipped.append(index)) if config.skip_failed else None
    work = partial(_open_job, Job(recipe, manifest, out, config))
    with one_writer(out):
        if config.overwrite:
            discard_dataset(out)
        store = DatasetStore(out, manifest)
        store.begin(plan.models, plan.camera, config.resume, config.shard)
        pending = [index for index in store.pending() if index in wanted]
        allowance = Allowance(out, config.max_gb, len(wanted) - len(pending), config.workers)
        progress(len(wanted) - len(pending), len(wanted))
        allowance.require_room(len(wanted) - len(pending), len(wanted))
        made = make_scenes(work, config.seed, pending, config.workers, limit_s, skip)
        written = list[SceneRecord]()
        with closing(made):
            for finished, (_, record) in enumerate(made, start=len(wanted) - len(pending) + 1):
                written.append(record)
                progress(finished, len(wanted))
                allowance.require_room(finished, len(wanted))
        if config.shard is None:
            return store.finish(skipped, written)
    return manifest.without(skipped) if len(skipped) < manifest.scenes else manifest


def make_scene(job: Job, scene_index: int, renderer: Renderer) -> SceneRecord:
    """Draw a scene and store it, whatever other scenes are there; return what is needed of it to finish the dataset."""
    prepared = prepare_scene(job.recipe, job.manifest.seed, scene_index)
    rig = storable(job.recipe.sensors, job.manifest.formats)
    level = bool(job.manifest.contents.levelled)
    observations = observe_scene(prepared.scene, rig, renderer, prepared.variants, level, prepared.caster)
    store = DatasetStore(job.root, job.manifest)
    outcome = Outcome(
        to_mapping(prepared.settle),
        renderer.description,
        occlusion=None if prepared.occlusion is None else to_mapping(prepared.occlusion),
        paired_variants=[(variant.name, variant.scene) for variant in prepared.variants[1:]],
        accessibility=accessibility(prepared.scene, TRUCKS[prepared.truck]),
    )
    return store.write_scene(prepared.scene, observations, outcome)


@contextmanager
def _open_job(job: Job) -> Iterator[Work]:
    """Open one renderer a process, for its whole life: contexts that come and go are what drivers leak."""
    with open_renderer(job.config.backend, **job.config.backend_options) as renderer:
        yield lambda index: make_scene(job, index, renderer)


_GB = 1e9


class Allowance:
    """Counts scenes, and measures the folder when so many are made that the limit could be near.

    Args:
        root: Folder of the dataset.
        limit_gb: What it may take (GB); None = as much as it does.
        made: Scenes that are there already.
        workers: How many scenes are made at once, each of which is on the disk in part.
    """

    def __init__(self, root: Path, limit_gb: float | None, made: int, workers: int) -> None:
        self._root, self._limit_gb, self._made, self._workers = root, limit_gb, made, workers
        self._safe, self._base = 0, 0 if made else self._used()

    def require_room(self, finished: int, total: int) -> None:
        """Reject to go on where the next scenes would not fit; before the first scene, and after each.

        Args:
            finished: Scenes that are there.
            total: Scenes of the dataset.

        Raises:
            OutputError: They would not.
        """
        if self._limit_gb is None or finished >= total:
            return
        self._safe -= finished - self._made
        self._made = finished
        if self._safe > 0:
            return
        used = self._used()
        each = (used - self._base) / finished if finished else 0.0
        room = self._limit_gb * _GB - used
        if room < self._workers * each or room < 0:
            raise OutputError(
                f"{self._root}: holds {used / _GB:.3f} GB with {finished} of {total} scenes, the next would exceed "
                f"--max-gb {self._limit_gb:g}; go on with --resume and a larger --max-gb"
            )
        # Half of what fits by the mean: scenes differ.
        self._safe = int(room / each / 2) - self._workers if each else 1

    def _used(self) -> int:
        return _bytes_of(self._root) if self._limit_gb is not None else 0


def _bytes_of(root: Path) -> int:
    """Return what the files of a folder take, each once; files that workers rename meanwhile may be missed."""
    found: dict[tuple[int, int], int] = {}
    for folder, _, names in os.walk(root):
        for name in names:
            with suppress(FileNotFoundError):
                status = os.stat(os.path.join(folder, name), follow_symlinks=False)
                found[status.st_dev, status.st_ino] = status.st_size
    return sum(found.values())
