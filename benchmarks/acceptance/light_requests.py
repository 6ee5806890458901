"""How well requested lux are reached, and what lighting a scene costs.

    python -m benchmarks.acceptance.light_requests            # prints the table
    python -m benchmarks.acceptance.light_requests --write    # and stores the result and its image

Each settled scene is lit once by every preset, each time with a request between 2 and 600 lx, all magnitudes alike
often. What counts as reached is the mean illuminance of the aisle's free floor by random walks (``floor_walks.py``),
not the measure that the lights were scaled by.
"""

import time
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median

import numpy as np
import tyro

from benchmarks.acceptance.floor_walks import floor_lux_by_walks
from benchmarks.result import RESULTS, rounded, write_result
from warehouse_sim.generation.light import light_scene
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.sampled import sample_settled_scene
from warehouse_sim.optional import require
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene import Distribution
from warehouse_sim.scene.lighting import PRESETS, LightingConfig
from warehouse_sim.scene.streams import scene_rng

ROOT = Path(__file__).parents[2]
PICTURE = "docs/images/light_requests.png"
RECIPES = ("industrial", "selective_rack", "dock_staging", "conveyor_pickup")
LOWEST, HIGHEST = 2.0, 600.0
WALKS = 6000
COLOURS = dict(zip(PRESETS, ("#6b7785", "#101418", "#c2405a", "#2f6fde", "#8a55d7", "#e07b1f", "#1d9a78"), strict=True))


@dataclass(frozen=True)
class Row:
    """One request."""

    recipe: str
    preset: str
    requested: float
    reached: float
    scene_s: float
    """CPU time for the scene without viewpoints (s)."""
    view_s: float
    """CPU time for a viewpoint more (s)."""


def requests_of(name: str, index: int, seed: int) -> list[Row]:
    """Light one scene by every preset."""
    recipe = load_recipe(name)
    settled = sample_settled_scene(recipe, seed, index).scene
    empty = replace(settled, viewpoints=())
    caster, camera = RayCaster(settled), recipe.sensors.make_camera()
    caster.cast(np.zeros((1, 3)), np.ones((1, 3)))
    rng, rows = scene_rng(seed, index, "light requests"), []
    for preset in PRESETS:
        requested = float(np.exp(rng.uniform(np.log(LOWEST), np.log(HIGHEST))))
        config = LightingConfig(preset=preset, lux=Distribution.constant(requested))
        start = time.process_time()
        light_scene(empty, config, caster, camera, scene_rng(seed, index, "lighting"))
        middle = time.process_time()
        scene = light_scene(settled, config, caster, camera, scene_rng(seed, index, "lighting"))
        end = time.process_time()
        reached = floor_lux_by_walks(scene, caster, WALKS, rng)
        views = (end - middle - (middle - start)) / len(settled.viewpoints)
        rows.append(Row(name, preset, requested, reached, middle - start, views))
    return rows


def table(rows: list[Row]) -> dict[str, float]:
    """Return what was measured by name."""
    errors = np.array([row.reached / row.requested - 1.0 for row in rows])
    values: dict[str, float] = {
        "requests": len(rows),
        "requests reached within 15 %": int((np.abs(errors) <= 0.15).sum()),
        "largest error (%)": 100 * float(np.abs(errors).max()),
        "mean error (%)": 100 * float(np.abs(errors).mean()),
    }
    for preset in PRESETS:
        mine = [abs(error) for row, error in zip(rows, errors, strict=True) if row.preset == preset]
        values[f"{preset}: largest error (%)"] = 100 * max(mine)
    for recipe in dict.fromkeys(row.recipe for row in rows):
        mine = [row for row in rows if row.recipe == recipe]
        values[f"{recipe}: CPU-ms a scene"] = 1000 * median(row.scene_s for row in mine)
        values[f"{recipe}: CPU-ms a viewpoint"] = 1000 * max(0.0, median(row.view_s for row in mine))
    return values


def draw_chart(rows: list[Row], path: Path) -> None:
    """Draw requested against reached lux, and both as histograms."""
    pyplot = require("matplotlib.pyplot", "report", "for charts")
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(10.5, 4.6), constrained_layout=True)
    ends = np.array([LOWEST / 1.3, HIGHEST * 1.3])
    left.fill_between(ends, 0.85 * ends, 1.15 * ends, color="#dfe5ec", label="within 15 %", zorder=1)
    for preset, colour in COLOURS.items():
        mine = [row for row in rows if row.preset == preset]
        x, y = [row.requested for row in mine], [row.reached for row in mine]
        left.scatter(x, y, s=12, color=colour, label=preset, zorder=3)
    left.set(xscale="log", yscale="log", xlabel="requested (lx)", ylabel="reached, by random walks (lx)")
    left.legend(fontsize=8, loc="upper left")
    edges = np.geomspace(LOWEST, HIGHEST, 12)
    right.hist([row.reached for row in rows], bins=edges, color="#2f6fde", rwidth=0.9, label="reached", zorder=2)
    requested = np.histogram([row.requested for row in rows], bins=edges)[0]
    right.stairs(requested, edges, color="#101418", linewidth=1.5, label="requested", zorder=3)
    right.set(xscale="log", xlabel="mean illuminance of the aisle's floor (lx)", ylabel=f"of {len(rows)} requests")
    right.legend(fontsize=8)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)
    pyplot.close(figure)


def main(scenes: int = 5, seed: int = 0, write: bool = False) -> None:
    """Light scenes of four recipes by every preset.

    Args:
        scenes: Scenes of each recipe.
        seed: Seed of the scenes.
        write: Store the result and its image.
    """
    rows = [row for name in RECIPES for index in range(scenes) for row in requests_of(name, index, seed)]
    values = table(rows)
    for name, value in values.items():
        print(f"{name:45s} {value:.4g}")
    if write:
        draw_chart(rows, ROOT / PICTURE)
        measured = [{"name": name, "value": value} for name, value in values.items()]
        command = f"python -m benchmarks.acceptance.light_requests --scenes {scenes} --seed {seed} --write"
        write_result(RESULTS / "light_requests.json", command, rounded(measured))


if __name__ == "__main__":
    tyro.cli(main)
