"""A scene recipe: the distribution that scenes are sampled from. Every setting has a default."""

from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from typing import Annotated, Any

import numpy as np

from warehouse_sim.catalog import catalog_object, shipped_classes
from warehouse_sim.catalog.loads.carton_wear import CartonWearConfig
from warehouse_sim.catalog.shipped import WORKING_CLASSES
from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import ConfigError, shown
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.scene.appearance.config import AppearanceConfig
from warehouse_sim.scene.building.hall import HallConfig
from warehouse_sim.scene.clutter import ClutterConfig
from warehouse_sim.scene.layouts import (  # noqa: F401 - a recipe can name each kind of layout that is imported
    block_storage,
    cantilever,
    conveyor_pickup,
    dock_staging,
    drive_in,
    mezzanine,
    mixed,
    small_parts,
)
from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig
from warehouse_sim.scene.layouts.site import Layout
from warehouse_sim.scene.lighting.config import LightingConfig
from warehouse_sim.scene.loads.lanes import LanesConfig
from warehouse_sim.scene.loads.shelving import ShelvingConfig
from warehouse_sim.scene.loads.staging import StagingConfig
from warehouse_sim.scene.loads.unit_load import UnitLoadConfig
from warehouse_sim.scene.random_settings import RandomSetting, find_random_settings, with_values
from warehouse_sim.scene.traffic import TrafficConfig
from warehouse_sim.scene.viewpoints.config import ViewpointsConfig


@dataclass(frozen=True)
@ranged
class SceneRecipe:
    """What a scene holds and from where it is seen; a number may be left open as a distribution."""

    layout: Layout = field(default_factory=RackAisleConfig)
    """What stands where."""
    hall: HallConfig = field(default_factory=HallConfig)
    """What the hall around it is made of."""
    loads: UnitLoadConfig = field(default_factory=UnitLoadConfig)
    """Pallets and the goods on them, wherever they stand."""
    shelving: ShelvingConfig = field(default_factory=ShelvingConfig)
    """Loads in racks and on conveyors."""
    lanes: LanesConfig = field(default_factory=LanesConfig)
    """Stacks of loads in floor lanes."""
    staging: StagingConfig = field(default_factory=StagingConfig)
    """Loads on the floor of the aisle."""
    traffic: TrafficConfig = field(default_factory=TrafficConfig)
    """People, trucks and what lies about on the floor of the aisle."""
    clutter: ClutterConfig = field(default_factory=ClutterConfig)
    """Small things that stand about on the floor."""
    carton_wear: CartonWearConfig = field(default_factory=CartonWearConfig)
    """Dents, crushed corners and bulging sides of cartons."""
    lights: LightingConfig = field(default_factory=LightingConfig)
    """Luminaires, daylight and exposure."""
    appearance: AppearanceConfig = field(default_factory=AppearanceConfig)
    """Paint, age, dirt and gloss of every kind of surface; the catalog's where nothing is said."""
    viewpoints: ViewpointsConfig = field(default_factory=ViewpointsConfig)
    """Where cameras look from, single or on drives."""
    observations_per_scene: Annotated[int, Range(1, 1000)] = 8
    """Viewpoints of each scene, 1-1,000."""
    targets: tuple[str, ...] = ("pallet",)
    """Class names whose objects get full labels."""
    random_settings: tuple[RandomSetting, ...] = ()
    """Filled in on reading: the settings that are sampled again for each scene."""

    def __post_init__(self) -> None:
        if self.layout.wants_goods and not self.loads.goods:
            raise ValueError("layout.goods_fraction needs articles; list them under loads.goods")
        own = {catalog_object(name).class_name for name in (*self.traffic.objects, *self.loads.goods)}
        shipped = {"pallet", "carton", *WORKING_CLASSES}
        known = shipped | own
        if not self.targets or not known.issuperset(self.targets):
            raise ValueError(
                f"targets must list classes among {', '.join(sorted(known))}, found {shown(list(self.targets))}"
            )
        for name in sorted(own.intersection(self.targets) - shipped):
            if name in shipped_classes():
                raise ValueError(
                    f"targets: {name} is also a class of the catalog, whose objects get no labels; give your own "
                    "objects another class_name"
                )

    @classmethod
    def from_plain(cls, data: Any, where: str) -> "SceneRecipe":
        """Read a mapping in which numbers may be distributions and names choices.

        Raises:
            ConfigError: A key or value cannot be used, or the least or largest values of what is open cannot.
        """
        if not isinstance(data, dict) or "random_settings" in data:
            raise ConfigError(f"{where}: expected a mapping of a scene's settings, without random_settings")
        found = find_random_settings(cls, data, where)
        for setting in found:
            if setting.path[0] in ("observations_per_scene", "targets"):
                raise ConfigError(f"{where}: {setting.path[0]} cannot be left open; all scenes share it")
        from_mapping(cls, with_values(data, [(setting.path, setting.end("high")) for setting in found]), where)
        recipe = from_mapping(cls, with_values(data, [(setting.path, setting.end("low")) for setting in found]), where)
        return replace(recipe, random_settings=found)

    def to_plain(self) -> dict[str, Any]:
        """Return what ``from_plain`` reads back."""
        plain = {item.name: to_mapping(getattr(self, item.name)) for item in fields(self)}
        del plain["random_settings"]
        return with_values(plain, [(setting.path, setting.source.to_plain()) for setting in self.random_settings])

    def sampled(self, stream: Callable[[str], np.random.Generator]) -> "SceneRecipe":
        """Return the recipe of one scene: every random setting has one value.

        Args:
            stream: Gives the random stream of a stage; each setting has its own, so that none disturbs another.

        Raises:
            ConfigError: Values that are fine alone are not together.
        """
        if not self.random_settings:
            return self
        values = [(item.path, item.sample(stream(f"recipe {item.name}"))) for item in self.random_settings]
        return from_mapping(SceneRecipe, with_values(self.to_plain(), values), "a draw of the recipe")
