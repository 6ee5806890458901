"""How many requests for a visible fraction are met, by what, and what they cost.

    python -m benchmarks.acceptance.occlusion_requests            # prints the table
    python -m benchmarks.acceptance.occlusion_requests --write    # and stores the result and its image

Each observation asks for a range of width 0.1 between 0.1 and 1, all ranges alike often. What counts is the visible
fraction in the annotation of the image drawn at full resolution, not the estimate that the search goes by.
"""

import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import tyro

from benchmarks.result import RESULTS, rounded, write_result
from warehouse_sim.annotate import annotate
from warehouse_sim.generation.occlusion import OcclusionConfig, RequestOutcome, VisibleFractions, request_views
from warehouse_sim.generation.recipe import Recipe, load_recipe
from warehouse_sim.generation.sampled import sample_settled_scene
from warehouse_sim.optional import require
from warehouse_sim.render import Renderer, open_renderer
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import ObjectAnnotation, SceneSpec

ROOT = Path(__file__).parents[2]
PICTURE = "docs/images/occlusion_requests.png"
COLOURS = {"view": "#6b7785", "border": "#8a55d7", "load": "#e07b1f", "wrap": "#c2a03a", "pallet": "#1d9a78"}
COLOURS |= {"traffic": "#2f6fde"}
NAMES = {"view": "a view as it is", "border": "camera turned", "load": "load placed", "wrap": "load in film placed"}
NAMES |= {"pallet": "pallets placed", "traffic": "person, truck, cone placed"}


@dataclass(frozen=True)
class Row:
    """One request and its annotation."""

    recipe: str
    outcome: RequestOutcome
    fraction: float
    cpu_s: float
    ray_s: float

    @property
    def met(self) -> bool:
        """Whether the annotation's fraction lies in the range."""
        return self.outcome.low <= self.fraction <= self.outcome.high


def requests_of(recipe: Recipe, index: int, seed: int, renderer: Renderer) -> Iterator[Row]:
    """Yield the requests of one scene with what was drawn for them."""
    sampled = sample_settled_scene(recipe, seed, index)
    settled = sampled.scene
    caster, camera = RayCaster(settled), recipe.sensors.make_camera()
    caster.cast(np.zeros((1, 3)), np.ones((1, 3)))  # the first ray finishes its structure, which others use too
    config, rng = OcclusionConfig(VisibleFractions.deciles()), sampled.stream("occlusion")
    with timed_rays() as rays:
        start = time.process_time()
        scene, report = request_views(settled, sampled.settings, camera, config, caster, rng)
        cpu = (time.process_time() - start) / len(report.requests)
    renderer.load(replace(scene, lights=()))  # ids and amodal masks are the same in the dark
    for outcome in report.requests:
        label = annotation(scene, outcome, recipe, renderer)
        fraction = label.visible_fraction if label is not None else 0.0
        yield Row(recipe.name, outcome, fraction, cpu, sum(rays) / len(report.requests))


def annotation(
    scene: SceneSpec, outcome: RequestOutcome, recipe: Recipe, renderer: Renderer
) -> ObjectAnnotation | None:
    """Draw a request's view and return its target's label."""
    T_world_camera, camera = scene.viewpoints[outcome.observation].T_world_camera, recipe.sensors.make_camera()
    targets = [item for item in scene.target_instances() if item.instance_id == outcome.target]
    buffers = renderer.render(camera, T_world_camera)
    amodal_masks = renderer.amodal_masks(camera, T_world_camera, targets)
    labels = annotate(scene, camera, T_world_camera, buffers, buffers.depth, amodal_masks, targets)
    return labels[0] if labels else None


@contextmanager
def timed_rays() -> Iterator[list[float]]:
    """Collect the CPU-seconds of all casts."""
    seconds: list[float] = []
    cast = RayCaster.cast

    def timed(self: RayCaster, *args: np.ndarray) -> object:
        start = time.process_time()
        try:
            return cast(self, *args)
        finally:
            seconds.append(time.process_time() - start)

    RayCaster.cast = timed  # type: ignore[method-assign,assignment]
    try:
        yield seconds
    finally:
        RayCaster.cast = cast  # type: ignore[method-assign]


def table(rows: list[Row]) -> dict[str, float]:
    """Return what was measured by name."""
    error = np.array([row.fraction - row.outcome.reached for row in rows])
    values: dict[str, float] = {"requests": len(rows), "requests met": sum(row.met for row in rows)}
    values["share met"] = values["requests met"] / len(rows)
    for name in sorted({row.recipe for row in rows}):
        mine = [row for row in rows if row.recipe == name]
        values[f"{name}: requests"] = len(mine)
        values[f"{name}: share met"] = sum(row.met for row in mine) / len(mine)
        values[f"{name}: CPU-ms a request"] = 1000 * float(np.mean([row.cpu_s for row in mine]))
        values[f"{name}: CPU-ms of rays a request"] = 1000 * float(np.mean([row.ray_s for row in mine]))
    values["views and occluders tried for a request"] = float(np.mean([row.outcome.tries for row in rows]))
    values["largest error of the fraction by rays"] = float(np.abs(error).max())
    values["mean error of the fraction by rays"] = float(np.abs(error).mean())
    values["objects placed for a request"] = float(np.mean([len(row.outcome.placed) for row in rows]))
    for means, count in sorted(Counter(row.outcome.means for row in rows).items()):
        values[f"reached by {NAMES[means]}"] = count
    for kind, count in sorted(Counter(row.outcome.kind for row in rows).items()):
        values[f"mostly hidden by {kind}"] = count
    for reason, count in sorted(Counter(row.outcome.reason for row in rows if not row.met).items()):
        values[f"missed: {reason or 'a pixel or two beyond the range'}"] = count
    return values


def draw_chart(rows: list[Row], path: Path) -> None:
    """Draw requested against reached fractions."""
    pyplot = require("matplotlib.pyplot", "report", "for charts")
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(10.5, 4.6), constrained_layout=True)
    jitter = np.random.default_rng(0).uniform(-0.035, 0.035, len(rows))
    for means in COLOURS:
        chosen = [i for i, row in enumerate(rows) if row.outcome.means == means]
        x = [(rows[i].outcome.low + rows[i].outcome.high) / 2 + jitter[i] for i in chosen]
        left.scatter(x, [rows[i].fraction for i in chosen], s=9, color=COLOURS[means], label=NAMES[means], zorder=3)
    edges = np.linspace(0.1, 1.0, 10)
    left.bar(edges[:-1] + 0.05, 0.1, 0.1, edges[:-1], color="#dfe5ec", zorder=1)
    left.set(xlabel="requested range", ylabel="reached, counted in the image", xlim=(0.05, 1.05), ylim=(0.0, 1.05))
    left.legend(fontsize=8, loc="upper left")
    counts = {means: [row.fraction for row in rows if row.outcome.means == means] for means in COLOURS}
    right.hist(
        list(counts.values()), bins=list(edges), stacked=True, color=list(COLOURS.values()), rwidth=0.9, zorder=2
    )
    middles = [(row.outcome.low + row.outcome.high) / 2 for row in rows]
    requested = np.histogram(middles, bins=edges)[0]
    right.stairs(requested, edges, color="#101418", linewidth=1.5, label="requested", zorder=3)
    right.set(xlabel="visible fraction", ylabel="observations")
    right.legend(fontsize=8, loc="lower right")
    for axes in (left, right):
        axes.grid(color="#8b949e", alpha=0.25, linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=110)
    pyplot.close(figure)


def main(
    recipes: tuple[str, ...] = ("industrial", "selective_rack", "demo"),
    requests: int = 510,
    seed: int = 0,
    write: bool = False,
) -> None:
    """Measure and print.

    Args:
        recipes: Names or paths of recipes.
        requests: Least number of requests, shared out evenly among the recipes.
        seed: Seed of the dataset.
        write: Store the result file and the image.
    """
    rows: list[Row] = []
    with open_renderer("raster") as renderer:
        for recipe in map(load_recipe, recipes):
            scenes = -(-requests // len(recipes) // recipe.scene.observations_per_scene)
            for index in range(scenes):
                rows += requests_of(recipe, index, seed, renderer)
            print(f"{recipe.name}: {scenes} scenes", flush=True)
    values = rounded(table(rows))
    for name, value in values.items():
        print(f"{name:60s} {value}")
    for row in rows:
        if not row.met:
            print(row)
    if write:
        command = f"python -m benchmarks.acceptance.occlusion_requests --requests {requests} --seed {seed} --write"
        store(rows, values, command)


def store(rows: list[Row], values: dict[str, float], command: str) -> None:
    """Write the result file and the image."""
    results = [{"name": name, "value": value} for name, value in values.items()]
    write_result(RESULTS / "occlusion_requests.json", command, results)
    draw_chart(rows, ROOT / PICTURE)


if __name__ == "__main__":
    tyro.cli(main)
