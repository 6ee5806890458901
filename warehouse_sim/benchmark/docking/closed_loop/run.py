"""All episodes of a recipe, scene by scene; what was driven before is not driven again."""

import hashlib
import json
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

from warehouse_sim.benchmark.docking.closed_loop.drive import ABORTS, DOCKED, Perceive
from warehouse_sim.benchmark.docking.closed_loop.episode import Row, Setting, episode, way_is_free
from warehouse_sim.benchmark.docking.closed_loop.perceive import LiveScene, Oracle, Seen, hidden_scene
from warehouse_sim.benchmark.docking.closed_loop.settings import CONDITIONS, DRIVE, Condition
from warehouse_sim.benchmark.docking.closed_loop.starts import Start, starts_in
from warehouse_sim.benchmark.docking.record import Kept
from warehouse_sim.benchmark.docking.truck import TRUCK
from warehouse_sim.benchmark.entrants.ways import Way
from warehouse_sim.benchmark.rows.simulated import Drive
from warehouse_sim.benchmark.suite import ApproachConfig
from warehouse_sim.dataset.formats.bop.models import even_mesh
from warehouse_sim.dataset.objects import ObjectInfo, object_info
from warehouse_sim.errors import ConfigError, PlacementError
from warehouse_sim.estimators.api import PoseEstimator
from warehouse_sim.generation.plan import target_models
from warehouse_sim.generation.recipe import Recipe, load_recipe
from warehouse_sim.generation.scene import SampledScene, sample_settled_scene
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.render import open_renderer
from warehouse_sim.render.renderer import Renderer
from warehouse_sim.schema import SceneSpec

ORACLE = "oracle"
"""The method that knows the pose."""
_MOST_BARREN = 20
"""After so many scenes without a start a recipe is given up."""
LEFT_OUT = "left out"
"""Outcome of an episode whose level cannot be had at its start."""


@dataclass(eq=False)
class Runner:
    """Episodes of one recipe.

    Args:
        source: Recipe.
        seed: Of its scenes.
        conditions: Levels.
        renderer: Renders the images.
        kept: Rows so far.
        ways: Who estimates beside the ground truth, by name.
        inputs: What the answers of each depend on, such as its weights.
        starts: Of each scene, at most.
    """

    source: str
    seed: int
    conditions: Sequence[Condition]
    renderer: Renderer
    kept: Kept
    ways: Mapping[str, Way]
    inputs: Mapping[str, object]
    starts: int = 2

    def rows(self, episodes: int) -> Iterator[Row]:
        """Yield the rows of ``episodes`` starts; each is driven under every level by every method.

        Raises:
            PlacementError: Its scenes leave no clearance for a truck.
        """
        scene = started = 0
        while started < episodes:
            if scene >= _MOST_BARREN and not started:
                raise PlacementError(f"{self.source}: a truck has clearance for an approach in none of {scene} scenes")
            key = self._key("scene", scene)
            if key not in self.kept:
                self.kept.add(key, {"starts": len(self._starts(scene))})
            for number in range(min(self.kept[key]["starts"], episodes - started)):
                yield from self._of_start(scene, number)
                started += 1
            scene += 1

    def _of_start(self, scene: int, number: int) -> Iterator[Row]:
        for condition in self.conditions:
            for method in (ORACLE, *self.ways):
                key = self._key("episode", scene, number, asdict(condition), method, self.inputs.get(method))
                if key not in self.kept:
                    start = self._starts(scene)[number]
                    begun = time.process_time()
                    perceive = self._perceive(start, condition, method)
                    if isinstance(perceive, str):
                        row = self._left_out(scene, number, condition, method, perceive)
                    else:
                        row, _ = episode(self._setting, start, condition, method, perceive)
                    row["cpu_s"] = time.process_time() - begun
                    self.kept.add(key, row)
                yield self.kept[key]

    def _left_out(self, scene: int, number: int, condition: Condition, method: str, why: str) -> Row:
        place = {"source": self.source, "scene": scene, "start": number}
        level = {"condition": condition.name, "factor": condition.factor, "method": method}
        return place | level | {"outcome": LEFT_OUT, "by": why}

    @cached_property
    def _recipe(self) -> Recipe:
        return load_recipe(self.source)

    @cached_property
    def _setting(self) -> Setting:
        return Setting(self._recipe.name, self.seed, self._recipe.sensors.make_camera())

    @cached_property
    def _objects(self) -> dict[int, ObjectInfo]:
        return objects_of(self._recipe)

    @cached_property
    def _opened(self) -> dict[str, PoseEstimator]:
        return {name: way.open(self._objects) for name, way in self.ways.items()}

    _sampled_of: tuple[int, SampledScene, list[Start]] | None = None
    _live_of: tuple[tuple[object, ...], LiveScene] | None = None
    _hidden_of: tuple[tuple[object, ...], SceneSpec | None, str] | None = None

    def _sampled(self, scene: int) -> tuple[SampledScene, list[Start]]:
        """Return a scene and its starts; the last one is kept."""
        if self._sampled_of is None or self._sampled_of[0] != scene:
            sampled = sample_settled_scene(self._recipe, self.seed, scene)
            self._sampled_of = (
                scene,
                sampled,
                starts_in(sampled, self._setting.camera, self.starts, partial(way_is_free, self._setting)),
            )
        return self._sampled_of[1:]

    def _starts(self, scene: int) -> list[Start]:
        return self._sampled(scene)[1]

    def _perceive(self, start: Start, condition: Condition, method: str) -> Perceive | str:
        """Return who estimates, or why the level cannot be had here."""
        scene, pallet = start.station.scene, start.pallet
        model = scene.model_of(pallet)
        if method == ORACLE:
            return Oracle(pallet, model, self._setting.camera)
        live = self._live(start, condition)
        if isinstance(live, str):
            return live
        estimator = self._opened[method]
        return Seen(live, estimator, pallet, model, start.number)

    def _live(self, start: Start, condition: Condition) -> LiveScene | str:
        """Return the loaded scene of a level; that of the last episode where it serves."""
        sampled, _ = self._sampled(start.station.scene.scene_index)
        hides = (start.number, condition.visible) if condition.visible else ()
        key = (sampled.scene.scene_index, condition.light, condition.sensor, *hides)
        if self._live_of is None or self._live_of[0] != key:
            hidden, why = self._hidden(sampled, start, condition)
            if why:
                return why
            settings = condition.light, condition.sensor, hidden, condition.hidden_for
            self._live_of = key, LiveScene(self._recipe, sampled, self.renderer, *settings)
        return self._live_of[1]

    def _hidden(self, sampled: SampledScene, start: Start, condition: Condition) -> tuple[SceneSpec | None, str]:
        if condition.visible is None:
            return None, ""
        key = (sampled.scene.scene_index, start.number, condition.visible)
        if self._hidden_of is None or self._hidden_of[0] != key:
            view, stream = start.mount.view(start.pose), f"closed loop hidden {start.number}"
            found = hidden_scene(self._recipe, sampled, view, start.pallet.instance_id, condition.visible, stream)
            self._hidden_of = key, *found
        return self._hidden_of[1:]

    def _key(self, *what: object) -> str:
        settings: Mapping[str, object] = {
            "source": self.source, "seed": self.seed, "starts": self.starts, "what": what,
            "drive": asdict(DRIVE), "truck": asdict(TRUCK),
        }  # fmt: skip
        return hashlib.sha256(json.dumps(settings, sort_keys=True).encode()).hexdigest()[:20]


def objects_of(recipe: Recipe) -> dict[int, ObjectInfo]:
    """Return what estimators need to know of a recipe's targets, by obj_id, with meshes in memory."""
    found = {}
    for model in target_models(recipe):
        meshes = {False: model.mesh(), True: even_mesh(model)}

        def read(obj_id: int, even: bool, meshes: dict[bool, TriangleMesh] = meshes) -> TriangleMesh:
            return meshes[even]

        found[model.obj_id] = replace(object_info(model, Path()), read_mesh=read)
    return found


def drives(config: ApproachConfig, ways: Mapping[str, Way], inputs: Mapping[str, Any], out: Path) -> Iterator[Drive]:
    """Yield how each episode ended, of the ground truth first; what was driven before is taken from ``out``.

    Args:
        config: Recipes, levels and how many starts.
        ways: Who estimates besides the ground truth.
        inputs: What else the answers of each depend on.
        out: Folder.

    Raises:
        ConfigError: There is no such level.
        PlacementError: A recipe leaves no clearance for a truck.
    """
    if strange := [name for name in config.levels if name not in CONDITIONS]:
        raise ConfigError(f"approach: levels: {strange[0]!r} is none; known: {', '.join(CONDITIONS)}")
    levels = [CONDITIONS[name] for name in config.levels]
    kept = Kept(out / "episodes.jsonl")
    with open_renderer("raster") as renderer:
        for recipe in config.recipes:
            runner = Runner(recipe, config.seed, levels, renderer, kept, ways, inputs)
            for row in runner.rows(config.episodes):
                if row["outcome"] != LEFT_OUT:
                    ended = row["outcome"]
                    yield Drive(row["method"], recipe, row["condition"], row["scene"], ended == DOCKED, ended in ABORTS)
