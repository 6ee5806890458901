"""What a dataset will be before any of it is made: its manifest with splits, and the geometries labels can name."""

import itertools
import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Annotated, Any

import numpy as np
from jaxtyping import Float

from warehouse_sim.annotate import targets_in_view
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.loads import OPEN_CARTONS
from warehouse_sim.catalog.traffic import TRAFFIC, WORKING_CLASSES
from warehouse_sim.config import to_mapping
from warehouse_sim.dataset.formats import dataset_format, needs_level_camera
from warehouse_sim.dataset.manifest import Manifest, PairedVariant, package_versions
from warehouse_sim.dataset.shards.shard import Shard
from warehouse_sim.dataset.split import split_scenes
from warehouse_sim.dataset.stored.contents import Contents
from warehouse_sim.dataset.stored.recipe_contents import draft_contents
from warehouse_sim.errors import ConfigError
from warehouse_sim.generation.executor import Work, make_scenes
from warehouse_sim.generation.licences import recipe_licences
from warehouse_sim.generation.light import LightMeter
from warehouse_sim.generation.occlusion.occluded_scene import OccludedScene
from warehouse_sim.generation.recipe import Recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.level_view import reach
from warehouse_sim.ranges import Range, Seed, ranged
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene.draft import Area
from warehouse_sim.scene.packing.pallet_choice import all_pallets
from warehouse_sim.scene.viewpoints import ViewpointsConfig
from warehouse_sim.scene.viewpoints.mountings import MOUNTINGS
from warehouse_sim.schema import ObjectModel

Degrees = tuple[float, float]


def largest_view_angle_deg(recipe: dict[str, Any], kinds: tuple[str, ...], camera: PinholeCamera) -> float:
    """Return the largest angle to the horizon (deg) that an image can reach in its level view.

    Args:
        recipe: The resolved recipe as plain data.
        kinds: Kinds of viewpoints that tilt the camera.
        camera: The rig's camera.
    """
    views = recipe.get("scene", {}).get("viewpoints", {})
    rolls = _ends(views.get("roll_deg", 0.0))
    turns = {turn for kind in kinds for turn in itertools.product(_pitches(kind, views), rolls)}
    return float(np.rad2deg(max((reach(camera, *np.deg2rad(turn)) for turn in turns), default=0.0)))


def _pitches(kind: str, views: dict[str, Any]) -> Degrees:
    """Return least and largest pitch of a kind (deg): the recipe's, or else its own."""
    if kind == "free":
        low, high = _ends(views.get("elevation_deg", ViewpointsConfig().elevation_deg.to_plain()))
        return -high, -low
    return _ends(views.get("pitch_deg") or MOUNTINGS[kind].pitch_deg.to_plain())


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
    scene, camera = prepare_scene(recipe, seed, scene_index).scene, recipe.sensors.make_camera()
    caster = RayCaster(scene)
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


@dataclass(frozen=True)
@ranged
class GenerateConfig:
    """How a dataset is made; workers, ``resume``, ``overwrite`` and ``scene_limit_s`` decide none of its bytes."""

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


def default_formats(recipe: Recipe) -> tuple[str, ...]:
    """Return the formats of a dataset for which nobody names any: KITTI and BOP; BOP alone where there is no LiDAR."""
    return ("kitti", "bop") if recipe.sensors.lidar is not None else ("bop",)


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
    models, camera = target_models(recipe), recipe.sensors.make_camera()
    manifest = draft_manifest(recipe, config)
    # Before scenes are measured for the split, which can take long.
    for name in manifest.formats:
        dataset_format(name).reject(manifest)
    if recipe.split.stratify:
        features = _features(recipe, config, manifest.scenes)
        splits = split_scenes(manifest.scenes, recipe.split, features)
        manifest = replace(manifest, splits={name: indices for name, indices in splits.items()})
    return DatasetPlan(manifest, models, camera)


def draft_manifest(recipe: Recipe, config: GenerateConfig) -> Manifest:
    """Return the manifest as far as it is known without making a scene: with splits by index.

    Raises:
        ConfigError: No format is named, or one twice.
    """
    if not config.formats:
        raise ConfigError("formats: a dataset needs one at least, such as kitti or bop; see warehouse-sim list")
    if len(set(config.formats)) < len(config.formats):
        raise ConfigError(f"formats: {' '.join(config.formats)} names one twice")
    scenes = recipe.scenes if config.scenes is None else config.scenes
    # Through JSON, so that a manifest read back equals the one written.
    plain = json.loads(json.dumps(to_mapping(recipe)))
    contents = _contents(plain, config, recipe.sensors.make_camera())
    return Manifest(
        seed=config.seed,
        scenes=scenes,
        observations_per_scene=recipe.scene.observations_per_scene * len(recipe.paired_variants.names()),
        splits={name: indices for name, indices in split_scenes(scenes, recipe.split).items()},
        formats=tuple(config.formats),
        targets=recipe.scene.targets,
        recipe=plain,
        packages=package_versions(),
        paired_variants=_paired_variants(recipe),
        contents=contents,
        backend=config.backend,
        backend_options=config.backend_options,
        licences=recipe_licences(plain, contents.plugins),
    )


def _contents(recipe: dict[str, Any], config: GenerateConfig, camera: PinholeCamera) -> Contents:
    """Return the contents, with the formats that hold a level virtual camera's images instead of a tilted one's."""
    contents = draft_contents(recipe, (*config.formats, config.backend))
    if not contents.tilted_viewpoints:
        return contents
    levelled = tuple(name for name in config.formats if needs_level_camera(dataset_format(name)))
    view_angle_deg = largest_view_angle_deg(recipe, contents.tilted_viewpoints, camera)
    return replace(contents, levelled=levelled, view_angle_deg=view_angle_deg)


def _paired_variants(recipe: Recipe) -> tuple[PairedVariant, ...]:
    names, groups = recipe.paired_variants.names(), range(recipe.scene.observations_per_scene)
    return tuple(PairedVariant(group, name) for name in names for group in groups) if len(names) > 1 else ()


def target_models(recipe: Recipe) -> list[ObjectModel]:
    """Return each geometry that a label of the recipe can name, once, in order of obj_id.

    Appearance and wear of one geometry share its obj_id; the first name the recipe lists stands for it.
    """
    loads = recipe.scene.loads
    opened = [name for name, (sku, _) in OPEN_CARTONS.items() if sku in loads.cartons and _opens(recipe)]
    others = (*loads.cartons, *opened, *loads.goods, *recipe.scene.traffic.objects)
    bulk = map(loads.pallet, loads.pallet_names)
    at_work = TRAFFIC if set(WORKING_CLASSES).intersection(recipe.scene.targets) else ()
    models = [*all_pallets(loads), *bulk, *(catalog_object(name) for name in (*others, *at_work))]
    targets = {model.obj_id: model for model in reversed(models) if model.class_name in recipe.scene.targets}
    return [targets[obj_id] for obj_id in sorted(targets)]


def _opens(recipe: Recipe) -> bool:
    """Return whether cartons of the recipe may stand open."""
    return recipe.scene.carton_wear.open_fraction > 0


def _features(recipe: Recipe, config: GenerateConfig, scenes: int) -> Float[np.ndarray, "n k"]:
    measured = dict(
        make_scenes(partial(_open_measure, recipe, config.seed), config.seed, range(scenes), config.workers)
    )
    return np.stack([measured[index] for index in range(scenes)])


@contextmanager
def _open_measure(recipe: Recipe, seed: int) -> Iterator[Work]:
    yield partial(scene_features, recipe, seed)
