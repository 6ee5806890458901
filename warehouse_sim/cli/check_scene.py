"""``warehouse-sim check-scene``: the evidence that a scene is physically possible."""

from math import degrees
from typing import TYPE_CHECKING

import tyro

from warehouse_sim.cli.console import say
from warehouse_sim.optional import require_extra

if TYPE_CHECKING:
    from warehouse_sim.physics import SettleConfig, SettleReport
    from warehouse_sim.schema import SceneSpec


def check_scene(recipe: tyro.conf.Positional[str], scene: int = 0, seed: int = 0) -> int:
    """Sample and settle one scene and print how it stands; exit code 1 when it breaks a limit in every attempt.

    Args:
        recipe: Name of a shipped recipe or path of a recipe file.
        scene: Index of the scene, >= 0.
        seed: Seed of the dataset, >= 0.
    """
    require_extra("generate", "to make scenes")
    from warehouse_sim.errors import PlacementError
    from warehouse_sim.generation.drawn import ATTEMPTS
    from warehouse_sim.generation.recipe import load_recipe
    from warehouse_sim.physics import settle_scene
    from warehouse_sim.scene import sample_scene

    loaded = load_recipe(recipe)
    say(f"sampling and settling scene {scene} of {recipe} with seed {seed}")
    for attempt in range(ATTEMPTS):
        try:
            spec = sample_scene(loaded.scene, seed, scene, attempt)
        except PlacementError as problem:
            print(f"attempt {attempt}: rejected: {problem}")
            continue
        settled, report = settle_scene(spec, loaded.settle)
        for line in _evidence(settled, report, loaded.settle):
            print(f"attempt {attempt}: {line}")
        if not report.problems:
            print(f"output: scene {scene} of {recipe} with seed {seed} stands in attempt {attempt}")
            print(f"next:   warehouse-sim preview {recipe} --scene {scene} --seed {seed}")
            return 0
        for line in report.problems:
            print(f"attempt {attempt}: FAIL  {line}")
    print(f"output: scene {scene} of {recipe} with seed {seed} breaks a limit in all of {ATTEMPTS} attempts")
    return 1


def _evidence(scene: "SceneSpec", report: "SettleReport", limits: "SettleConfig") -> list[str]:
    """Return what was measured and, where there is one, the limit."""
    classes = [scene.model_of(item).class_name for item in scene.instances]
    loose = sum(item.dynamic for item in scene.instances)
    counts = ", ".join(f"{classes.count(name)} {name}" for name in sorted(set(classes)))
    mm = 1000.0
    return [
        f"{len(classes)} objects: {counts}",
        f"{loose} loose objects in {report.stacks} stacks, each at rest within {report.duration:.2f} s",
        f"speed        {report.max_speed:9.5f} m/s   limit {limits.rest_speed:g}",
        f"overlap      {mm * report.max_overlap:9.3f} mm    limit {limits.max_overlap_mm:g}",
        f"floating     {mm * report.max_gap:9.3f} mm    limit {limits.max_gap_mm:g}",
        f"lowest point {mm * report.lowest:9.3f} mm    limit {-limits.max_overlap_mm:g}, the floor is 0",
        f"drift        {mm * report.max_drift:9.3f} mm    limit {limits.max_drift_mm:g}, before knocks",
        f"tilt         {degrees(report.max_tilt):9.3f} deg   limit {limits.max_tilt_deg:g}, before knocks",
        f"{len(report.knocked)} loads knocked: {len(report.shifted)} pieces shifted, {len(report.leaning)} leaning, "
        f"{len(report.fallen)} fallen",
    ]
