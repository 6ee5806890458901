"""Paint a scene: every kind of surface that varies gets its looks, and each object's paint says which are its own."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from warehouse_sim.catalog.materials import materials, smooth_materials
from warehouse_sim.scene.appearance.coating import Look, coated
from warehouse_sim.scene.appearance.config import AppearanceConfig
from warehouse_sim.scene.appearance.palettes import PaintConfig
from warehouse_sim.scene.appearance.surfaces import SURFACES, Surface
from warehouse_sim.schema import Material, ObjectInstance, SceneSpec

MOST_MATERIALS = 2000
"""Materials of a scene beyond which no new ones are made: what comes later shares the looks that are there."""


def paint_scene(scene: SceneSpec, config: AppearanceConfig, stream: Callable[[str], np.random.Generator]) -> SceneSpec:
    """Return ``scene`` with its objects painted and its textures chosen; geometry, ids and light stay.

    Args:
        scene: As the catalog paints it.
        config: What varies.
        stream: Gives the random stream of a stage; each kind of surface has its own, so that none disturbs another.
    """
    catalog = materials() if config.surfaces == "used" else smooth_materials()
    pot = _Pot({name: catalog.get(name, item) for name, item in scene.materials.items()}, catalog)
    paints: dict[int, dict[str, str]] = {}
    for name, paint in config.resolved().items():
        surface, rng = SURFACES[name], stream(f"appearance {name}")
        _paint_surface(scene, surface, _Shelf(name, surface, paint, pot, rng), paints, rng)
    instances = tuple(
        replace(item, paint={**item.paint, **paints[item.instance_id]}) if item.instance_id in paints else item
        for item in scene.instances
    )
    return replace(scene, instances=instances, materials=pot.materials)


class _Pot:
    """The materials of a scene, which grow as it is painted."""

    def __init__(self, found: dict[str, Material], catalog: dict[str, Material]) -> None:
        self.materials, self._catalog = found, catalog

    def mix(self, base: str, look: Look, name: str) -> str | None:
        """Add ``base`` in a look under ``name``; return the name, or None where there are too many already."""
        if name not in self.materials:
            if len(self.materials) >= MOST_MATERIALS:
                return None
            self.materials[name] = coated(self._catalog[base], look, name, self._catalog["galvanised"])
        return name


class _Shelf:
    """The looks of one kind of surface in one scene."""

    def __init__(self, name: str, surface: Surface, paint: PaintConfig, pot: _Pot, rng: np.random.Generator) -> None:
        self._name, self._pot = name, pot
        count = surface.looks * (len(surface.materials) if surface.apart else 1)
        looks = [Look.of(paint, surface.palette, rng) for _ in range(count)]
        self._looks = {
            material: looks[place :: len(surface.materials)] if surface.apart else looks
            for place, material in enumerate(surface.materials)
        }

    def paint(self, material: str, number: int) -> str:
        """Return the name of ``material`` in look ``number``, or in one that there is already."""
        for at in range(number, -1, -1):
            found = self._pot.mix(material, self._looks[material][at], f"{material} {self._name} {at}")
            if found is not None:
                return found
        return material


def _paint_surface(
    scene: SceneSpec, surface: Surface, shelf: _Shelf, paints: dict[int, dict[str, str]], rng: np.random.Generator
) -> None:
    used = {name: _used(scene, name, surface) for name in dict.fromkeys(item.model for item in scene.instances)}
    chosen: dict[object, int] = {}
    for item in scene.instances:
        if used[item.model]:
            number = chosen.setdefault(_thing(item, surface), int(rng.integers(surface.looks)))
            own = {material: shelf.paint(material, number) for material in used[item.model]}
            paints.setdefault(item.instance_id, {}).update(own)


def _used(scene: SceneSpec, model: str, surface: Surface) -> list[str]:
    """Return the materials of this kind of surface that a model has."""
    found = scene.models[model]
    if surface.classes is not None and found.class_name not in surface.classes:
        return []
    return sorted({part.material for part in found.parts}.intersection(surface.materials))


def _thing(item: ObjectInstance, surface: Surface) -> object:
    """Return what shares a look with ``item``."""
    if surface.scope == "scene":
        return "scene"
    return (item.group, item.model) if surface.scope == "load" and item.group else item.instance_id
