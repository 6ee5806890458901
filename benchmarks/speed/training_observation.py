"""One observation to train with: RGB, depth, masks and poses as BOP files, by the command, everything included."""

import json
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from benchmarks.speed.subject import Settings
from warehouse_sim.generation.recipe import load_recipe

RECIPES = (
    "selective_rack",
    "very_narrow_aisle",
    "dock_staging",
    "block_storage",
    "mixed_pallets",
    "domain_random",
)
OUTPUTS = ("rgb", "depth", "masks", "poses")
_SCENES, _MANY = 2, 24


def training_observation(settings: Settings) -> dict[str, Any]:
    """Return the row: the mean over recipes, whatever recipe the settings name, and the worst of them.

    Each number is the CPU time of ``warehouse-sim generate`` with one worker, its start included, over the observations
    that it made.
    """
    table = [_of_recipe(name, settings) for name in RECIPES[: 1 if settings.quick else None]]
    many = [row["cpu_s"] for row in table]
    return {
        "what": f"an observation of {' '.join(OUTPUTS)} as BOP files, {_MANY} a scene, start included, mean",
        "value": statistics.mean(many),
        "worst": max(many),
        "target": "<= 0.5, worst <= 0.8",
        "scenes": _SCENES,
        "table": table,
    }


def _of_recipe(name: str, settings: Settings) -> dict[str, Any]:
    own = load_recipe(name)
    count = 2 if settings.quick else _MANY
    many, size = _generate(name, count, settings.seed)
    few, _ = _generate(name, 1 if settings.quick else own.scene.observations_per_scene, settings.seed)
    camera = own.sensors.make_camera()
    return {
        "recipe": name,
        "size_wh": [camera.width, camera.height],
        "cpu_s": many,
        "own_observations_per_scene": own.scene.observations_per_scene,
        "own_cpu_s": few,
        "megabytes": size,
    }


def _generate(name: str, observations: int, seed: int) -> tuple[float, float]:
    """Return CPU-seconds and megabytes an observation."""
    with tempfile.TemporaryDirectory() as folder:
        recipe, out = Path(folder) / "views.yaml", Path(folder) / "data"
        changes = {"scene": {"observations_per_scene": observations}, "sensors": {"lidar": None}}
        recipe.write_text(json.dumps({"extends": name, "description": "many views", **changes}), encoding="utf-8")
        command = [sys.executable, "-m", "warehouse_sim", "generate", str(recipe), "--out", str(out)]
        command += ["--scenes", str(_SCENES), "--seed", str(seed), "--workers", "1", "--formats", "bop"]
        before = _children_cpu_s()
        subprocess.run([*command, "--outputs", *OUTPUTS], check=True, stdout=subprocess.DEVNULL)
        spent, count = _children_cpu_s() - before, _SCENES * observations
        size = sum(path.stat().st_size for path in out.rglob("*") if path.is_file())
    return spent / count, size / 1e6 / count


def _children_cpu_s() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
