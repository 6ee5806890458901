"""``warehouse-sim preview``: render a scene of a recipe before generating from it."""

from pathlib import Path

import tyro

from warehouse_sim.cli.console import finish, require_ending, say
from warehouse_sim.cli.replacing import require_free
from warehouse_sim.errors import InputError
from warehouse_sim.optional import require_extra

_OUT = Path("preview.png")


def preview(
    recipe: tyro.conf.Positional[str],
    seed: int = 0,
    scene: int = 0,
    difficulty: float | None = None,
    backend: str = "raster",
    backend_options: tuple[str, ...] = (),
    samples: int | None = None,
    denoise: bool = False,
    out: Path = _OUT,
    check: bool = False,
    json: Path | None = None,
) -> int:
    """Render a contact sheet of a scene: RGB, depth, instance mask, boxes, LiDAR from above, any other sensors.

    With --check nothing is rendered: it prints how the settled scene stands (overlap, floating, drift, crush) against
    the recipe's limits; exit code 1 when it breaks one.

    Args:
        recipe: Name of a shipped recipe or path of a recipe file.
        seed: Seed of the dataset, >= 0.
        scene: Index of the scene, >= 0.
        difficulty: Moves clutter, occlusion, light and noise together, 0 = easy to 1 = hard; by default the recipe's.
        backend: Render backend.
        backend_options: Options of that backend, as ``key=value``.
        samples: Paths a pixel of the path tracer: its option ``samples``.
        denoise: Take the noise out of path traced images: its option ``denoise=true``.
        out: PNG file to write.
        check: Print how the settled scene stands, and render nothing.
        json: With --check, file for the same numbers.
    """
    require_extra("generate", "to make scenes")
    if check:
        drawn = {
            "out": out != _OUT, "backend": backend != "raster", "backend-options": backend_options, "samples": samples,
            "denoise": denoise,
        }  # fmt: skip
        if given := [f"--{name}" for name, value in drawn.items() if value not in (None, False, ())]:
            raise InputError(f"--check renders nothing; leave {' and '.join(given)} out")
        from warehouse_sim.cli.scene_check import check_scene

        return check_scene(recipe, scene, seed, json, difficulty)
    if json is not None:
        raise InputError("--json belongs to --check; add --check, or leave it out")
    from warehouse_sim.generation.contact_sheet import render_contact_sheet
    from warehouse_sim.generation.difficulty import with_difficulty
    from warehouse_sim.generation.recipe import load_recipe
    from warehouse_sim.render import option_settings, with_shortcuts

    pairs = with_shortcuts(backend, backend_options, {"samples": samples, "denoise": denoise})
    options = option_settings(backend, pairs)
    chosen = load_recipe(recipe)
    if difficulty is not None:
        chosen = with_difficulty(chosen, difficulty)
    require_ending("--out", out, ".png")
    require_free(out, overwrite=True)
    say(f"sampling, settling and rendering scene {scene} of {recipe} with seed {seed}")
    render_contact_sheet(chosen, seed, scene, out, backend, options)
    same = [] if difficulty is None else ["--difficulty", str(difficulty)]
    same += [] if backend == "raster" else ["--backend", backend]
    same += ["--backend-options", *pairs] if pairs else []
    finish(out, "generate", recipe, "--out", f"out/{Path(recipe).stem}", "--seed", str(seed), *same)
    return 0
