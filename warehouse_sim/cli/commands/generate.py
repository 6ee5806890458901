"""``warehouse-sim generate``: a recipe becomes a dataset folder."""

import shlex
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import tyro

from warehouse_sim.cli.checks import processes
from warehouse_sim.cli.console import count_progress, finish, say
from warehouse_sim.cli.many_machines import SLURM, Elsewhere, on_ray, on_slurm
from warehouse_sim.errors import InputError, WarehouseSimError
from warehouse_sim.optional import require_extra

if TYPE_CHECKING:
    from warehouse_sim.dataset.manifest import Manifest
    from warehouse_sim.generation.plan import GenerateConfig
    from warehouse_sim.generation.recipe import Recipe


def generate(
    recipe: tyro.conf.Positional[str | None] = None,
    *,
    out: Path | None = None,
    merge: tuple[Path, ...] = (),
    scenes: int | None = None,
    seed: int = 0,
    formats: tuple[str, ...] = (),
    outputs: tuple[str, ...] = (),
    backend: str = "raster",
    backend_options: tuple[str, ...] = (),
    samples: int | None = None,
    denoise: bool = False,
    difficulty: float | None = None,
    workers: int | None = None,
    resume: bool = False,
    shard: str | None = None,
    scene_limit: float | None = None,
    skip_failed: bool = False,
    overwrite: bool = False,
    plan: bool = False,
    max_gb: float | None = None,
    on: str | None = None,
    shards: str | None = None,
    tasks: int = 8,
) -> None:
    """Sample, settle, render and label scenes; ``manifest.json`` is written last.

    With --merge the shards that several machines made become one dataset: the same bytes as one run, files linked
    where the disk can.

    Args:
        recipe: Name of a shipped recipe or path of a recipe file.
        out: Dataset folder to make.
        merge: In place of a recipe, the folders of all shards, in any order.
        scenes: Number of scenes; the recipe's own number by default.
        seed: Seed of the dataset, >= 0; the same seed gives the same bytes whatever the number of workers.
        formats: Dataset formats to write; by default kitti and bop, or bop alone where the rig has no LiDAR.
        outputs: What to hold of an observation, in place of the recipe's ``sensors.outputs``, as rgb depth masks poses;
            ``default`` for the usual ones, see docs/dataset.md.
        backend: Render backend.
        backend_options: Options of that backend, as ``key=value``.
        samples: Paths a pixel of the path tracer: its option ``samples``.
        denoise: Take the noise out of path traced images: its option ``denoise=true``.
        difficulty: Moves clutter, occlusion, light and noise together, 0 = easy to 1 = hard; by default the recipe's.
        workers: Processes; one per processor by default.
        resume: Go on with a run that was interrupted; finished scenes are kept.
        shard: Make only every n-th scene, as ``i/n`` with i from 0, into a folder that ``--merge`` puts together.
        scene_limit: Seconds that a try of a scene may take; by default 600 for each of its observations.
        skip_failed: Do without scenes that failed twice; ``manifest.json`` names them under ``missing``.
        overwrite: Remove the dataset that stands in the folder first.
        plan: Make one scene apart, say what the dataset costs, and write nothing to ``--out``.
        max_gb: Stop before the folder takes more than this (GB), from the first scene of each worker on; ``--resume``
            goes on.
        on: Other machines that make the scenes: ``ray``, ``ray://HOST`` or ``slurm-array``, see docs/many_machines.md.
        shards: With --on, where they store their shards: a folder that all machines reach, for Ray also any place of
            fsspec (``s3://bucket/data``); by default beside ``--out``.
        tasks: With ``--on slurm-array``, tasks of the array, each with ``--workers`` processors (1).
    """
    count = processes(workers)
    if out is None and not plan:
        raise InputError("generate needs --out DIR, the folder to make; only --plan does without")
    out = out or Path()
    if (recipe is None) == (not merge):
        raise InputError("generate takes a recipe or --merge DIR [...]; see warehouse-sim list recipes")
    if overwrite and resume:
        raise InputError("--overwrite begins again and --resume goes on; give one of them")
    if merge:
        of_recipes = {
            "scenes": scenes, "seed": seed, "formats": formats, "outputs": outputs, "backend": backend != "raster",
            "samples": samples, "backend-options": backend_options, "denoise": denoise, "difficulty": difficulty,
            "workers": workers, "shard": shard, "scene-limit": scene_limit, "plan": plan, "max-gb": max_gb, "on": on,
            "shards": shards,
        }  # fmt: skip
        given = [f"--{name}" for name, value in of_recipes.items() if value not in (None, False, 0, ())]
        if given:
            raise InputError(f"--merge takes all that from the shards; leave {' and '.join(given)} out")
        _merge(merge, out, resume, skip_failed, overwrite)
        return
    assert recipe is not None
    require_extra("generate", "to make scenes")
    from warehouse_sim.api.generate import with_outputs, write_dataset
    from warehouse_sim.api.recipe import recipe as read_recipe
    from warehouse_sim.dataset.shards.shard import parse_shard
    from warehouse_sim.generation.plan import GenerateConfig
    from warehouse_sim.render import option_settings, with_shortcuts

    pairs = with_shortcuts(backend, backend_options, {"samples": samples, "denoise": denoise})
    chosen = with_outputs(read_recipe(recipe, difficulty=difficulty).resolved, outputs)
    config = GenerateConfig(
        scenes=scenes,
        seed=seed,
        formats=formats,
        backend=backend,
        backend_options=option_settings(backend, pairs),
        workers=count,
        resume=resume,
        overwrite=overwrite,
        shard=None if shard is None else parse_shard(shard),
        scene_limit_s=scene_limit,
        skip_failed=skip_failed,
        max_gb=max_gb,
    )
    if plan:
        _print_plan(chosen, config, out)
        return
    if on is not None:
        _elsewhere(recipe, difficulty, outputs, chosen, config, out, Elsewhere(on, shards, tasks, workers or 1))
        return
    if shards is not None:
        raise InputError("--shards says where --on stores shards; give --on too, or leave it out")
    alone = partial(_alone, recipe, difficulty, outputs, config, scenes or chosen.scenes, out)
    try:
        with count_progress("scenes") as progress:
            manifest = write_dataset(chosen, out, config, progress)
    except WarehouseSimError as problem:
        _name(problem.scenes, alone)
        raise
    _name(manifest.missing, alone)
    _print_facts(out, manifest)
    if shard is None:
        finish(out, "validate", out)
    else:
        finish(out, "generate", "--merge", "FOLDERS_OF_ALL_SHARDS", "--out", "DIR")


def _elsewhere(
    name: str,
    difficulty: float | None,
    outputs: Sequence[str],
    recipe: "Recipe",
    config: "GenerateConfig",
    out: Path,
    where: Elsewhere,
) -> None:
    """Let other machines make the dataset."""
    from warehouse_sim.api.generate import complete

    if config.shard is not None or config.max_gb is not None or config.resume:
        raise InputError("--on makes all shards and goes on by itself; leave --shard, --max-gb and --resume out")
    whole = complete(recipe, config)
    if where.on == SLURM:
        scenes = config.scenes or recipe.scenes
        on_slurm(_arguments(name, difficulty, outputs, whole, scenes), recipe, whole, out, where)
        return
    _print_facts(out, on_ray(recipe, whole, out, where))
    finish(out, "validate", out)


def _print_plan(recipe: "Recipe", config: "GenerateConfig", out: Path) -> None:
    """Print what the dataset will cost and hold."""
    from warehouse_sim.api.generate import plan_cost

    found = plan_cost(recipe, config, out)
    print(f"scenes: {found.scenes} of {found.observations_per_scene} observations, judged by one of them")
    print(f"time: {found.cpu_hours:.2f} CPU-hours, {found.wall_hours:.2f} h with {found.workers} workers")
    each = 1e6 / (found.scenes * found.observations_per_scene)
    for name, size in {**found.gb_by_folder, "together": found.gb}.items():
        print(f"{name}: {size:.3f} GB, {size * each:.0f} kB an observation")
    print(f"an observation: {found.targets:.1f} targets, {found.dockable:.1f} pallets that can be docked at")
    limit = "" if config.max_gb is None else f", --max-gb {config.max_gb:g}"
    print(f"free disk: {found.free_gb:.1f} GB{limit}")
    if found.gb > min(found.free_gb, config.max_gb or found.free_gb):
        say("the dataset does not fit; make fewer scenes, or name fewer formats")


def _merge(shards: Sequence[Path], out: Path, resume: bool, skip_failed: bool, overwrite: bool) -> None:
    """Put shards together into one dataset."""
    from warehouse_sim.dataset.manifest import read_manifest
    from warehouse_sim.dataset.shards.merge import merge as run

    with count_progress("shards") as progress:
        run(tuple(shards), out, resume, progress, skip_failed, overwrite)
    _print_facts(out, read_manifest(out))
    finish(out, "validate", out)


def _print_facts(out: Path, manifest: "Manifest") -> None:
    """Print what the scenes came out as."""
    from warehouse_sim.dataset.card.of_dataset import missing_test, realised

    for line in realised(out, manifest):
        print(line)
    warning = missing_test(manifest)
    if warning is not None:
        say(warning)


def _name(scenes: Sequence[int], alone: Callable[[int], str]) -> None:
    """Say of each scene that could not be made how to make it alone."""
    for index in scenes:
        say(f"scene {index} could not be made; alone: {alone(index)}")


def _alone(
    recipe: str,
    difficulty: float | None,
    outputs: Sequence[str],
    config: "GenerateConfig",
    total: int,
    out: Path,
    scene_index: int,
) -> str:
    """Return the command that makes one scene of the dataset, into a folder of its own."""
    command = ["warehouse-sim", "generate", *_arguments(recipe, difficulty, outputs, config, total)]
    place = ["--out", f"{out}-scene-{scene_index}", "--shard", f"{scene_index}/{total}", "--workers", "1"]
    return shlex.join([*command, *place])


def _arguments(
    recipe: str, difficulty: float | None, outputs: Sequence[str], config: "GenerateConfig", total: int
) -> list[str]:
    """Return the arguments of ``generate`` that decide the bytes of a dataset."""
    command = [recipe, "--seed", str(config.seed), "--scenes", str(total)]
    command += [*(["--formats", *config.formats] if config.formats else []), "--backend", config.backend]
    command += ["--outputs", *outputs] if outputs else []
    if config.backend_options:
        command += ["--backend-options", *(f"{key}={value}" for key, value in config.backend_options.items())]
    return [*command, *([] if difficulty is None else ["--difficulty", str(difficulty)])]
