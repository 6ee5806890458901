"""What a dataset will be before any of it is made: its manifest with splits, and the geometries labels can name.

A split that shall be alike in what its targets look like is made of features that are measured in every scene first.
"""

import itertools
import json
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Annotated, Any

import numpy as np
from jaxtyping import Float

from warehouse_sim.annotate import targets_in_view
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.loads.open_cartons import OPEN_CARTONS
from warehouse_sim.catalog.mesh_files import SUFFIXES
from warehouse_sim.catalog.shipped import TRAFFIC, WORKING_CLASSES
from warehouse_sim.config import to_mapping
from warehouse_sim.dataset.card.text import data_licences
from warehouse_sim.dataset.files.json_file import read_json
from warehouse_sim.dataset.formats import dataset_format, needs_level_camera
from warehouse_sim.dataset.formats.fit import held, needed, require_fit, require_place
from warehouse_sim.dataset.manifest import Manifest, PairedVariant, package_versions
from warehouse_sim.dataset.shards.shard import Shard
from warehouse_sim.dataset.split import split_scenes
from warehouse_sim.dataset.stored.contents import Contents
from warehouse_sim.dataset.stored.recipe_contents import draft_contents
from warehouse_sim.errors import ConfigError
from warehouse_sim.generation.executor import Work, make_scenes
from warehouse_sim.generation.light import LightMeter
from warehouse_sim.generation.occlusion.occluded_scene import OccludedScene
from warehouse_sim.generation.recipe import Recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.level_view import reach
from warehouse_sim.ranges import Range, Seed, ranged
from warehouse_sim.resources import data_folder
from warehouse_sim.scene.draft import Area
from warehouse_sim.scene.packing.pallet_choice import all_pallets
from warehouse_sim.scene.viewpoints.mountings import MOUNTINGS
from warehouse_sim.schema import ObjectModel
from warehouse_sim.schema.outputs import Output
from warehouse_sim.sensors.rig import RigConfig


@dataclass(frozen=True)
@ranged
class GenerateConfig:
    """How a dataset is made; ``workers``, ``resume``, ``overwrite`` and both limits decide none of its bytes."""

    scenes: Annotated[int, Range(1, 1_000_000)] | None = None
    """Number of scenes, 1-1,000,000; the recipe's own number by default."""
    seed: Seed = 0
    """Seed of the dataset, >= 0."""
    formats: tuple[str, ...] = ("kitti", "bop")
    """Dataset formats to write."""
    backend: str = "raster"
    """Render backend."""
    backend_options: dict[str, Any] = field(default_factory=dict)
    """Options of the backend that are not its defaults, see ``render.option_settings``."""
    workers: Annotated[int, Range(1, 256)] = 1
    """Processes, 1-256; 1 works in this process."""
    resume: bool = False
    """Keep the finished scenes of an interrupted run."""
    overwrite: bool = False
    """Remove the dataset that stands in the folder, once all settings are checked."""
    shard: Shard | None = None
    """Make only the scenes of this shard; the folder is one of several that ``dataset.shards.merge`` puts together."""
    scene_limit_s: Annotated[float, Range(1, 10_000_000, "s")] | None = None
    """How long a try of a scene may take, 1-10,000,000 s; None = ten minutes for each of its observations."""
    skip_failed: bool = False
    """Do without scenes that failed twice; the manifest names them."""
    max_gb: Annotated[float, Range(0.001, 1_000_000, "GB")] | None = None
    """Stop before the folder takes more than this, 0.001-1,000,000 GB; None = as much as it does."""


def default_formats(recipe: Recipe) -> tuple[str, ...]:
    """Return the formats of a dataset for which nobody names any: KITTI and BOP; BOP alone where KITTI lacks a part."""
    fits = recipe.sensors.lidar is not None and needed(dataset_format("kitti")) <= set(recipe.sensors.wanted)
    return ("kitti", "bop") if fits else ("bop",)


_MAY_REST: frozenset[Output] = frozenset({"lidar", "right"})
"""Outputs whose sensors need not read where no format has a place for them."""


def storable(rig: RigConfig, formats: Sequence[str]) -> RigConfig:
    """Return a rig that does without the sensors whose readings none of these formats holds."""
    resting = _MAY_REST - held(formats)
    return replace(rig, outputs=tuple(name for name in rig.wanted if name not in resting))


@dataclass(frozen=True, eq=False)
class DatasetPlan:
    """A dataset before any of it is made."""

    manifest: Manifest
    """With the splits that the recipe requires."""
    models: list[ObjectModel]
    """Each geometry that a label can name."""
    camera: PinholeCamera
    """The rig's camera."""


def plan_dataset(recipe: Recipe, config: GenerateConfig) -> DatasetPlan:
    """Return what the dataset that ``recipe`` and ``config`` describe will be.

    Raises:
        ConfigError: No format is named, or one twice.
        DatasetError: A format cannot hold the dataset.
        SettleError: A scene that must be measured for a stratified split does not stand in any attempt.
        WorkerError: A scene that must be measured ended every worker that made it.
    """
    _require_formats(config.formats)
    models, camera = target_models(recipe), recipe.sensors.make_camera()
    names, groups = recipe.paired_variants.names(), range(recipe.scene.observations_per_scene)
    scenes = config.scenes or recipe.scenes
    # Through JSON, so that a manifest read back equals the one written.
    plain = json.loads(json.dumps(to_mapping(recipe)))
    contents = planned_contents(plain, camera, config.formats, config.backend)
    undivided = Manifest(
        seed=config.seed,
        scenes=scenes,
        observations_per_scene=len(groups) * len(names),
        splits={"train": tuple(range(scenes)), "val": (), "test": ()},
        formats=tuple(config.formats),
        targets=recipe.scene.targets,
        recipe=plain,
        packages=package_versions(),
        paired_variants=tuple(PairedVariant(i, name) for name in names for i in groups) if len(names) > 1 else (),
        contents=contents,
        backend=config.backend,
        backend_options=config.backend_options,
        licences=recipe_licences(plain, contents.plugins),
    )
    # Before scenes are measured for the split, which can take long.
    require_fit(undivided)
    require_place(plain, undivided.formats)
    features = measured_features(recipe, config.seed, scenes, config.workers) if recipe.split.stratify else None
    return DatasetPlan(replace(undivided, splits=split_scenes(scenes, recipe.split, features)), models, camera)


def _require_formats(formats: tuple[str, ...]) -> None:
    if not formats:
        raise ConfigError("formats: a dataset needs one at least, such as kitti or bop; see warehouse-sim list")
    if len(set(formats)) < len(formats):
        raise ConfigError(f"formats: {' '.join(formats)} names one twice")


def target_models(recipe: Recipe) -> list[ObjectModel]:
    """Return each geometry that a label of the recipe can name, once, in order of obj_id.

    Appearance and wear of one geometry share its obj_id; the first name the recipe lists stands for it.
    """
    loads, may_open = recipe.scene.loads, recipe.scene.carton_wear.open_fraction > 0
    opened = [name for name, (sku, _) in OPEN_CARTONS.items() if sku in loads.cartons and may_open]
    others = (*loads.cartons, *opened, *loads.goods, *recipe.scene.traffic.objects)
    bulk = map(loads.pallet, loads.pallet_names)
    at_work = TRAFFIC if set(WORKING_CLASSES).intersection(recipe.scene.targets) else ()
    models = [*all_pallets(loads), *bulk, *(catalog_object(name) for name in (*others, *at_work))]
    targets = {model.obj_id: model for model in reversed(models) if model.class_name in recipe.scene.targets}
    return [targets[obj_id] for obj_id in sorted(targets)]


_BROUGHT = (".yaml", ".yml", ".ies", *SUFFIXES)
"""Endings by which a setting names a file instead of something that is shipped."""


def recipe_licences(recipe: dict[str, Any], plugins: Iterable[str]) -> dict[str, str]:
    """Return what is licensed how in a dataset of a resolved recipe.

    Args:
        recipe: As plain data.
        plugins: Third-party packages that take part.
    """
    named = [file for text in _texts(recipe) if (file := text.partition("#")[0]).lower().endswith(_BROUGHT)]
    return data_licences(texture_licence(), named, plugins)


def texture_licence() -> str:
    """Return the licence of the shipped textures, all of them where they differ (SPDX)."""
    files = read_json(data_folder("assets") / "manifest.json")["files"]
    return " AND ".join(sorted({entry["licence"] for entry in files}))


def _texts(data: Any) -> Iterator[str]:
    """Yield all texts of plain data; keys, too, since mixtures name objects as keys of their fractions."""
    if isinstance(data, dict):
        for key, value in data.items():
            yield from _texts(key)
            yield from _texts(value)
    elif isinstance(data, list):
        for value in data:
            yield from _texts(value)
    elif isinstance(data, str):
        yield data


Degrees = tuple[float, float]


def planned_contents(recipe: dict[str, Any], camera: PinholeCamera, formats: Sequence[str], backend: str) -> Contents:
    """Return what a dataset of a recipe will hold.

    Args:
        recipe: The resolved recipe as plain data, whose settings may be distributions and choices.
        camera: The rig's camera.
        formats: Names of the formats.
        backend: Name of the render backend.
    """
    contents = draft_contents(recipe, (*formats, backend))
    if not contents.tilted_viewpoints:
        return contents
    views = recipe["scene"]["viewpoints"]
    rolls = _ends(views["roll_deg"])
    turns = {turn for kind in contents.tilted_viewpoints for turn in itertools.product(_pitches(kind, views), rolls)}
    farthest = max(reach(camera, *np.deg2rad(turn)) for turn in turns)
    levelled = tuple(name for name in formats if needs_level_camera(dataset_format(name)))
    return replace(contents, levelled=levelled, view_angle_deg=float(np.rad2deg(farthest)))


def _pitches(kind: str, views: dict[str, Any]) -> Degrees:
    """Return least and largest pitch of a kind (deg): the recipe's, or else its own."""
    if kind == "free":
        low, high = _ends(views["elevation_deg"])
        return -high, -low
    return _ends(views["pitch_deg"] or MOUNTINGS[kind].pitch_deg.to_plain())


def _ends(plain: Any) -> Degrees:
    """Return least and largest value of a distribution as a manifest holds it."""
    if not isinstance(plain, dict):
        return float(plain), float(plain)
    values = plain.get("choices") or [plain["min"], plain["max"]]
    return float(min(values)), float(max(values))


_RAYS = 200
"""Rays through each target; its visible fraction is then known to about 0.05."""


def scene_features(recipe: Recipe, seed: int, scene_index: int) -> Float[np.ndarray, " k"]:
    """Return the means of ``recipe.split.stratify`` over the targets in view of one scene.

    "lux" is the mean illuminance of the aisle's floor (lx), "distance" from camera to target (m).

    Raises:
        SettleError: The scene does not stand in any attempt.
    """
    prepared, camera = prepare_scene(recipe, seed, scene_index), recipe.sensors.make_camera()
    scene, caster = prepared.scene, prepared.caster
    area = Area(*scene.aisle) if scene.aisle is not None else Area(0.0, 0.0, 0.0, 0.0)
    occluded = OccludedScene(scene, caster, camera, area, recipe.scene.viewpoints.clearance)
    fractions, distances = [], []
    for viewpoint in scene.viewpoints:
        for item in targets_in_view(scene, camera, viewpoint.T_world_camera):
            sight = occluded.look(item.instance_id, viewpoint.T_world_camera, _RAYS)
            if sight is not None and sight.fraction > 0.0:
                fractions.append(sight.fraction)
                distances.append(np.linalg.norm(item.T_world_object[:3, 3] - viewpoint.T_world_camera[:3, 3]))
    means = {
        "visible_fraction": float(np.mean(fractions)) if fractions else 0.0,
        "distance": float(np.mean(distances)) if distances else 0.0,
        "lux": LightMeter(scene, caster).floor_lux if "lux" in recipe.split.stratify else 0.0,
    }
    return np.array([means[name] for name in recipe.split.stratify])


def measured_features(recipe: Recipe, seed: int, scenes: int, workers: int) -> Float[np.ndarray, "n k"]:
    """Return ``scene_features`` of every scene of a dataset, one row a scene.

    Raises:
        SettleError: A scene does not stand in any attempt.
        WorkerError: A scene ended every worker that made it.
    """
    measured = dict(make_scenes(partial(_open_measure, recipe, seed), seed, range(scenes), workers))
    return np.stack([measured[index] for index in range(scenes)])


@contextmanager
def _open_measure(recipe: Recipe, seed: int) -> Iterator[Work]:
    yield partial(scene_features, recipe, seed)
