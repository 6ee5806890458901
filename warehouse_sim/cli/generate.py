"""``warehouse-sim generate``: a recipe becomes a dataset folder."""

import os
from pathlib import Path

import tyro

from warehouse_sim.cli.console import count_progress, finish
from warehouse_sim.optional import require_extra


def generate(
    recipe: tyro.conf.Positional[str],
    out: Path,
    scenes: int | None = None,
    seed: int = 0,
    formats: tuple[str, ...] = ("kitti", "bop"),
    backend: str = "raster",
    backend_options: tuple[str, ...] = (),
    samples: int | None = None,
    denoise: bool = False,
    difficulty: float | None = None,
    workers: int | None = None,
    resume: bool = False,
    shard: str | None = None,
) -> None:
    """Sample, settle, render and label scenes; ``manifest.json`` is written last.

    Args:
        recipe: Name of a shipped recipe or path of a recipe file.
        out: Dataset folder to make.
        scenes: Number of scenes; the recipe's own number by default.
        seed: Seed of the dataset, >= 0; the same seed gives the same bytes whatever the number of workers.
        formats: Dataset formats to write.
        backend: Render backend.
        backend_options: Options of that backend, as ``key=value``.
        samples: Paths a pixel of the path tracer: its option ``samples``.
        denoise: Take the noise out of path traced images: its option ``denoise=true``.
        difficulty: Moves clutter, occlusion, light and noise together, 0 = easy to 1 = hard; by default the recipe's.
        workers: Processes; one per processor by default.
        resume: Go on with a run that was interrupted; finished scenes are kept.
        shard: Make only every n-th scene, as ``i/n`` with i from 0, into a folder that ``merge`` puts together.
    """
    require_extra("generate", "to make scenes")
    from warehouse_sim.dataset.shard import parse_shard
    from warehouse_sim.generation.difficulty import with_difficulty
    from warehouse_sim.generation.generate import generate as run
    from warehouse_sim.generation.plan import GenerateConfig
    from warehouse_sim.generation.recipe import load_recipe
    from warehouse_sim.render import option_settings, with_shortcuts

    pairs = with_shortcuts(backend, backend_options, {"samples": samples, "denoise": denoise})
    config = GenerateConfig(
        scenes=scenes,
        seed=seed,
        formats=formats,
        backend=backend,
        backend_options=option_settings(backend, pairs),
        workers=workers or os.cpu_count() or 1,
        resume=resume,
        shard=None if shard is None else parse_shard(shard),
    )
    chosen = load_recipe(recipe)
    with count_progress("scenes") as progress:
        run(chosen if difficulty is None else with_difficulty(chosen, difficulty), out, config, progress)
    if shard is None:
        finish(out, "validate", out)
    else:
        finish(out, "merge", "FOLDERS_OF_ALL_SHARDS", "--out", "DIR")
