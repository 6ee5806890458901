"""``warehouse-sim preview``: render a scene of a recipe before generating from it, or check that it is possible."""

from dataclasses import asdict
from math import degrees
from pathlib import Path
from typing import TYPE_CHECKING

import tyro

from warehouse_sim.cli.checks import require_free
from warehouse_sim.cli.console import finish, require_ending, say
from warehouse_sim.errors import InputError
from warehouse_sim.optional import require_extra
from warehouse_sim.output import make_folder

if TYPE_CHECKING:
    from warehouse_sim.physics import CrushState, SettleConfig, SettleReport
    from warehouse_sim.schema import SceneSpec

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
        return _check_scene(recipe, scene, seed, json, difficulty)
    if json is not None:
        raise InputError("--json belongs to --check; add --check, or leave it out")
    from warehouse_sim.generation.contact_sheet import render_contact_sheet
    from warehouse_sim.generation.recipe import load_recipe
    from warehouse_sim.generation.recipe.difficulty import with_difficulty
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


def _check_scene(recipe: str, scene: int, seed: int, json: Path | None, difficulty: float | None = None) -> int:
    """Sample and settle one scene and print how it stands; exit code 1 when it breaks a limit in every attempt.

    Contacts that break the crush rule are named, with the weights that the contacts of the settled scene give; they
    count where the recipe keeps the rule (loads.stacking.crush_rule).

    Args:
        recipe: Name of a shipped recipe or path of a recipe file.
        scene: Index of the scene, >= 0.
        seed: Seed of the dataset, >= 0.
        json: File for the same numbers, with each contact that breaks the rule.
        difficulty: Of the scene, 0 = easy to 1 = hard; by default the recipe's.
    """
    from warehouse_sim.dataset.files.json_file import write_json
    from warehouse_sim.errors import PlacementError
    from warehouse_sim.generation.recipe import load_recipe
    from warehouse_sim.generation.recipe.difficulty import with_difficulty
    from warehouse_sim.generation.scene import ATTEMPTS
    from warehouse_sim.physics import crush_state, settle_scene
    from warehouse_sim.scene import sample_scene

    loaded = load_recipe(recipe)
    if difficulty is not None:
        loaded = with_difficulty(loaded, difficulty)
    say(f"sampling and settling scene {scene} of {recipe} with seed {seed}")
    for attempt in range(ATTEMPTS):
        try:
            spec = sample_scene(loaded.scene, seed, scene, attempt)
        except PlacementError as problem:
            print(f"attempt {attempt}: rejected: {problem}")
            continue
        settled, report = settle_scene(spec, loaded.settle)
        crush = crush_state(settled, report.struck)
        for line in (*_measured(settled, report, loaded.settle), *_crush_lines(crush)):
            print(f"attempt {attempt}: {line}")
        if json is not None:
            make_folder(json.parent)
            write_json(json, {"attempt": attempt, "settled": asdict(report), "crush": crush.to_plain()})
        broken = [fault.text for fault in crush.faults] if loaded.scene.loads.stacking.crush_rule else []
        for line in (*report.problems, *broken):
            print(f"attempt {attempt}: FAIL  {line}")
        if not report.problems:
            verdict = f"breaks the crush rule in {len(broken)} places of" if broken else "stands in"
            print(f"output: scene {scene} of {recipe} with seed {seed} {verdict} attempt {attempt}")
            harder = "" if difficulty is None else f" --difficulty {difficulty:g}"
            print(f"next:   warehouse-sim preview {recipe} --scene {scene} --seed {seed}{harder}")
            return 1 if broken else 0
    print(f"output: scene {scene} of {recipe} with seed {seed} breaks a limit in all of {ATTEMPTS} attempts")
    return 1


def _crush_lines(crush: "CrushState") -> list[str]:
    """Return what goods bear."""
    return [
        f"crush        {100 * crush.highest:9.1f} %     limit 100 of what a piece bears, {crush.contacts} contacts",
        f"crush rule   {len(crush.faults):9d} broken, {crush.layers} layers and loads on goods",
    ]


def _measured(scene: "SceneSpec", report: "SettleReport", limits: "SettleConfig") -> list[str]:
    """Return what was measured and, where there is one, the limit."""
    from warehouse_sim.physics.settle import MAX_GAP_MM, MAX_OVERLAP_MM, REST_SPEED

    classes = [scene.model_of(item).class_name for item in scene.instances]
    loose = sum(item.dynamic for item in scene.instances)
    counts = ", ".join(f"{classes.count(name)} {name}" for name in sorted(set(classes)))
    mm = 1000.0
    return [
        f"{len(classes)} objects: {counts}",
        f"{loose} loose objects in {report.stacks} stacks, each at rest within {report.duration:.2f} s",
        f"speed        {report.max_speed:9.5f} m/s   limit {REST_SPEED:g}",
        f"overlap      {mm * report.max_overlap:9.3f} mm    limit {MAX_OVERLAP_MM:g}",
        f"floating     {mm * report.max_gap:9.3f} mm    limit {MAX_GAP_MM:g}",
        f"lowest point {mm * report.lowest:9.3f} mm    limit {-MAX_OVERLAP_MM:g}, the floor is 0",
        f"drift        {mm * report.max_drift:9.3f} mm    limit {limits.max_drift_mm:g}, before impulses",
        f"tilt         {degrees(report.max_tilt):9.3f} deg   limit {limits.max_tilt_deg:g}, before impulses",
        f"{len(report.struck)} loads struck: {len(report.shifted)} pieces shifted, {len(report.leaning)} leaning, "
        f"{len(report.fallen)} fallen",
    ]
