"""How often scenes stand at the first attempt, how varied a set of them is, and what a dense one costs.

    python -m benchmarks.speed.scene_statistics            # prints the table
    python -m benchmarks.speed.scene_statistics --write    # and stores benchmarks/results/scene_statistics.json

Every recipe is sampled and settled scene by scene, without rendering. A draw is rejected when loads find no place or
when the settled scene breaks a limit; the next attempt is another scene of the same index. Meshes are counted by their
bytes, models by name (a damaged pallet is a model of its own), materials by name, over all scenes of a recipe. The
dense scene has no fewer than 200 loaded pallets and 3,000 cartons.
"""

import hashlib
import logging
import time
from collections import Counter
from dataclasses import dataclass, field

import tyro

from benchmarks.speed.result import RESULTS, write_result
from warehouse_sim.errors import PlacementError
from warehouse_sim.generation.recipe import Recipe, load_recipe
from warehouse_sim.generation.scene import ATTEMPTS
from warehouse_sim.physics import SettleConfig, settle_scene
from warehouse_sim.render import open_renderer
from warehouse_sim.scene import Distribution, SceneRecipe, sample_scene
from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig
from warehouse_sim.scene.loads.shelving import ShelvingConfig
from warehouse_sim.scene.loads.staging import StagingConfig
from warehouse_sim.scene.loads.unit_load import UnitLoadConfig
from warehouse_sim.schema import SceneSpec

RECIPES = ("industrial", "selective_rack", "block_storage", "dock_staging", "mixed_pallets", "conveyor_pickup")
DENSE = SceneRecipe(
    layout=RackAisleConfig(bays=12, beam_levels=(1.45, 2.9, 4.35), sides="both"),
    shelving=ShelvingConfig(empty_slot_fraction=0.2),
    staging=StagingConfig(count=Distribution.constant(0)),
    loads=UnitLoadConfig(empty_fraction=0.0, height=Distribution.uniform(0.6, 1.1), max_cartons=32),
)

_log = logging.getLogger(__name__)


@dataclass
class Tally:
    """What was seen of one recipe."""

    scenes: int = 0
    attempts: int = 0
    unplaced: int = 0
    unsettled: int = 0
    failed: list[int] = field(default_factory=list)
    cpu_s: float = 0.0
    loose: int = 0
    struck: int = 0
    shifted: int = 0
    leaning: int = 0
    fallen: int = 0
    models: set[str] = field(default_factory=set)
    meshes: set[str] = field(default_factory=set)
    materials: set[str] = field(default_factory=set)
    reasons: Counter[str] = field(default_factory=Counter)

    def rows(self, name: str) -> list[dict[str, float | str]]:
        """Return the recipe's rows of the result."""
        values = {
            "scenes that stand": self.scenes - len(self.failed),
            "scenes that fail, reported": len(self.failed),
            "attempts": self.attempts,
            "attempts rejected": round((self.unplaced + self.unsettled) / self.attempts, 4),
            "attempts rejected for lack of space": round(self.unplaced / self.attempts, 4),
            "attempts rejected by physics": round(self.unsettled / self.attempts, 4),
            "loose objects a scene": round(self.loose / self.scenes, 1),
            "loads struck": self.struck,
            "pieces shifted": self.shifted,
            "pieces leaning": self.leaning,
            "pieces fallen": self.fallen,
            "distinct models": len(self.models),
            "distinct meshes": len(self.meshes),
            "distinct materials": len(self.materials),
            "CPU-seconds a scene": round(self.cpu_s / self.scenes, 2),
        }
        return [{"name": f"{name}: {key}", "value": value} for key, value in values.items()]


def tally_recipe(recipe: Recipe, scenes: int, seed: int) -> Tally:
    """Sample and settle the first ``scenes`` scenes of a recipe."""
    tally = Tally()
    for index in range(scenes):
        start = time.process_time()
        scene = _settle(recipe, seed, index, tally)
        tally.cpu_s += time.process_time() - start
        tally.scenes += 1
        if scene is None:
            tally.failed.append(index)
        else:
            _count(scene, tally)
    return tally


def _settle(recipe: Recipe, seed: int, index: int, tally: Tally) -> SceneSpec | None:
    for attempt in range(ATTEMPTS):
        tally.attempts += 1
        try:
            spec = sample_scene(recipe.scene, seed, index, attempt)
        except PlacementError as problem:
            tally.unplaced += 1
            tally.reasons["no room"] += 1
            _log.info("%s", problem)
            continue
        scene, report = settle_scene(spec, recipe.settle)
        if not report.problems:
            tally.struck += len(report.struck)
            tally.shifted += len(report.shifted)
            tally.leaning += len(report.leaning)
            tally.fallen += len(report.fallen)
            return scene
        tally.unsettled += 1
        tally.reasons[" ".join(word for word in report.problems[0].split() if not any(map(str.isdigit, word)))] += 1
        _log.info("scene %d, attempt %d: %s", index, attempt, report.problems[:4])
    return None


def _count(scene: SceneSpec, tally: Tally) -> None:
    tally.loose += sum(item.dynamic for item in scene.instances)
    tally.materials |= set(scene.materials)
    for name, model in scene.models.items():
        if name not in tally.models:
            tally.models.add(name)
            tally.meshes |= {hashlib.sha256(part.mesh.vertices.tobytes()).hexdigest() for part in model.parts}


def dense_scene(seed: int) -> list[dict[str, float | str]]:
    """Sample, settle and render the dense scene."""
    start = time.process_time()
    spec = sample_scene(DENSE, seed, 0)
    sampled = time.process_time()
    scene, report = settle_scene(spec, SettleConfig())
    settled = time.process_time()
    report.require_ok()
    camera = load_recipe("demo").sensors.make_camera()
    with open_renderer("raster") as renderer:
        renderer.load(scene)
        for viewpoint in scene.viewpoints:
            renderer.render(camera, viewpoint.T_world_camera)
    rendered = time.process_time()
    classes = Counter(scene.model_of(item).class_name for item in scene.instances)
    values = {
        "loaded pallets": classes["pallet"],
        "cartons": classes["carton"],
        "CPU-seconds to sample": round(sampled - start, 2),
        "CPU-seconds to settle and check": round(settled - sampled, 2),
        "CPU-seconds to load and render 8 views": round(rendered - settled, 2),
        "deepest overlap, mm": round(1000 * report.max_overlap, 4),
        "largest gap, mm": round(1000 * report.max_gap, 4),
    }
    return [{"name": f"dense scene: {key}", "value": value} for key, value in values.items()]


def main(
    recipes: tuple[str, ...] = RECIPES,
    scenes: int = 100,
    seed: int = 0,
    write: bool = False,
    verbose: bool = False,
) -> None:
    """Measure and print.

    Args:
        recipes: Names or paths of recipes.
        scenes: Scenes of each.
        seed: Seed of the dataset.
        write: Store the result file.
        verbose: Say of each rejected draw why.
    """
    logging.basicConfig(level=logging.INFO if verbose else logging.WARNING)
    rows = dense_scene(seed)
    for name in recipes:
        tally = tally_recipe(load_recipe(name), scenes, seed)
        rows += tally.rows(name)
        print(f"{name}: {dict(tally.reasons)}", flush=True)
    for row in rows:
        print(f"{row['name']:58s} {row['value']}")
    if write:
        command = f"python -m benchmarks.speed.scene_statistics --scenes {scenes} --seed {seed} --write"
        write_result(RESULTS / "scene_statistics.json", command, rows)


if __name__ == "__main__":
    tyro.cli(main)
