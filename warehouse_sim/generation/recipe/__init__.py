"""A whole recipe file: the scene's distribution and what is done with each draw of it."""

import logging
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, Literal

from warehouse_sim.catalog import catalog_object
from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.dataset.split import SplitConfig
from warehouse_sim.errors import ConfigError, RecipeError
from warehouse_sim.generation.occlusion.config import OcclusionConfig
from warehouse_sim.generation.recipe.extends import overlay, read_chain
from warehouse_sim.generation.recipe.paired_variants import PairedVariantsConfig, overlaid
from warehouse_sim.physics.settle import SettleConfig
from warehouse_sim.ranges import Range, degrees_of_radians, ranged
from warehouse_sim.resources import find_recipe
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.recipe import SceneRecipe
from warehouse_sim.sensors.rig import RigConfig

log = logging.getLogger(__name__)
Place = Literal["shelf", "pallet", "floor"]
"""On the shelves of the layout, stacked on pallets, standing on the floor of the aisle."""
_OTHER_GOODS = ("tote_fraction", "drum_fraction", "sack_fraction")


@dataclass(frozen=True)
@ranged
class Recipe:
    """What a recipe file holds; every draw is decided by it, the seed and the scene index."""

    description: str
    """One sentence on what the scenes show."""
    scene: SceneRecipe
    """The distribution that scenes are sampled from."""
    settle: SettleConfig = field(default_factory=SettleConfig)
    """How loads come to rest."""
    sensors: RigConfig = field(default_factory=RigConfig)
    """The sensor rig of every observation."""
    occlusion: OcclusionConfig | None = None
    """How much of the target of each observation shall be visible; null = as it comes."""
    paired_variants: PairedVariantsConfig = field(default_factory=PairedVariantsConfig)
    """Which observations come again with one thing changed."""
    split: SplitConfig = field(default_factory=SplitConfig)
    """Fractions of the scenes for training, validation and test."""
    scenes: Annotated[int, Range(1, 1_000_000)] = 10
    """Number of scenes when the command does not say, 1-1,000,000."""
    name: str = ""
    """Filled in from the file's name."""


def load_recipe(name_or_path: str, changes: Mapping[str, Any] | None = None, instead: Collection[str] = ()) -> Recipe:
    """Read a recipe by shipped name ("demo") or path; what it ``extends`` is read and checked before it.

    Args:
        name_or_path: Which recipe.
        changes: Settings in place of its own, as a recipe that extends it has them.
        instead: Keys of ``changes`` that replace all that it says under them, instead of a part.

    Raises:
        UnknownNameError: Neither a shipped name nor a file.
        RecipeError: The file, or one that it extends, holds something that a recipe does not take.
    """
    path = find_recipe(name_or_path)
    settings: dict[str, Any] = {}
    for file, own in read_chain(path):
        # A name belongs to one file; all else is handed on.
        settings = overlay({key: value for key, value in settings.items() if key != "name"}, own)
        recipe = _checked(settings, str(file))
        _warn_of_radians(own, str(file))
    if changes:
        _warn_of_radians(changes, "settings from Python")
        recipe = _overlaid(settings, changes, instead)
    recipe = _at_camera_height(recipe)
    return recipe if recipe.name else replace(recipe, name=path.stem)


def changed(recipe: Recipe, changes: Mapping[str, Any], instead: Collection[str] = ()) -> Recipe:
    """Return a recipe with some of its settings replaced, as ``load_recipe`` does.

    Raises:
        RecipeError: A setting does not exist or does not fit.
    """
    plain: dict[str, Any] = to_mapping(recipe)
    return _at_camera_height(_overlaid(plain, changes, instead)) if changes else recipe


def with_own_object(
    recipe: Recipe, name: str, places: Sequence[Place], fraction: float, count: tuple[int, int]
) -> Recipe:
    """Return a recipe that has one more object, whose class is a target.

    A layout without bare shelves keeps its goods on pallets in racks: there, shelves are those.

    Args:
        recipe: What to add it to.
        name: Catalog name, or file as a recipe writes it.
        places: Where it comes.
        fraction: Of the loaded pallets, or of the shelves, that hold goods of the user's own, 0-1.
        count: Least and greatest number of the user's own things on the floor.

    Raises:
        RecipeError: No place, or one that does not take it.
    """
    if not places:
        raise RecipeError(f"places: {name} comes nowhere; name shelf, pallet or floor")
    if not 0.0 < fraction <= 1.0:
        raise RecipeError(f"fraction must be above 0 and at most 1, found {fraction}")
    model, scene = catalog_object(name), recipe.scene
    settings: dict[str, Any] = {"targets": list(dict.fromkeys((*scene.targets, model.class_name)))}
    if "floor" in places:
        low, high = count
        settings["traffic"] = {"objects": _joined(scene.traffic.objects, name), "own": {"min": low, "max": high}}
    loads: dict[str, Any] = {}
    has_shelves = scene.layout.has_shelves
    if "shelf" in places and has_shelves:
        settings["layout"] = {"goods_fraction": fraction}
    if "pallet" in places or ("shelf" in places and not has_shelves):
        others = sum(getattr(scene.loads, key) for key in _OTHER_GOODS)
        loads["goods_fraction"] = min(fraction, 1.0 - others)
    if set(places) != {"floor"}:
        if model.mass <= 0.0:
            raise RecipeError(f"{name}: has no mass, so that it cannot be stacked; give it one in its .yaml file")
        settings["loads"] = loads | {"goods": _joined(scene.loads.goods, name)}
    return changed(recipe, {"scene": settings})


def _joined(names: Sequence[str], name: str) -> list[str]:
    return list(dict.fromkeys((*names, name)))


def _overlaid(settings: dict[str, Any], changes: Mapping[str, Any], instead: Collection[str]) -> Recipe:
    kept = {key: value for key, value in settings.items() if key not in instead}
    return _checked(overlay(kept, dict(changes)), "settings from Python")


def _checked(settings: dict[str, Any], where: str) -> Recipe:
    """Return the recipe of plain settings.

    Raises:
        RecipeError: A key or value does not belong there.
    """
    try:
        recipe = from_mapping(Recipe, settings, where)
        for paired_variant in recipe.paired_variants.lights:
            overlaid(
                recipe.scene.lights, paired_variant.settings, f"{where}: paired variants.lights {paired_variant.name!r}"
            )
    except ConfigError as problem:
        raise RecipeError(str(problem)) from problem
    return recipe


def _warn_of_radians(settings: Any, where: str, is_angle: bool = False) -> None:
    """Warn of angles in degrees that read like radians."""
    if isinstance(settings, Mapping):
        for key, value in settings.items():
            _warn_of_radians(value, f"{where}: {key}", is_angle or str(key).endswith("_deg"))
    elif isinstance(settings, (list, tuple)):
        for value in settings:
            _warn_of_radians(value, where, is_angle)
    elif is_angle and isinstance(settings, (int, float)):
        degrees = degrees_of_radians(settings)
        if degrees is not None:
            log.warning("%s: %g looks like radians and is taken for degrees; %d degrees?", where, settings, degrees)


def _at_camera_height(recipe: Recipe) -> Recipe:
    """Return the recipe with its rig's own camera height, unless its viewpoints name one."""
    height, views = recipe.sensors.camera_height, recipe.scene.viewpoints
    if height is None or views.height is not None or views.kind == "free":
        return recipe
    return replace(recipe, scene=replace(recipe.scene, viewpoints=replace(views, height=Distribution.constant(height))))
