"""Paint a scene: every kind of surface that varies gets its looks, and each object's paint says which are its own."""

import colorsys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from warehouse_sim.catalog.materials import materials, smooth_materials
from warehouse_sim.catalog.textures import TEXTURES
from warehouse_sim.color import LUMINANCE, linear_from_srgb
from warehouse_sim.scene.appearance.config import AppearanceConfig, PaintConfig
from warehouse_sim.scene.appearance.surfaces import SURFACES, Finish, Surface
from warehouse_sim.schema import Material, ObjectInstance, ObjectModel, SceneSpec

_DUST = np.array([0.23, 0.21, 0.18])
"""Albedo of what settles in halls: concrete dust, board fibres and abraded rubber; an estimate."""
_HIDDEN = 0.45
"""Fraction of a surface that the thickest dirt hides."""
_STAINED_FROM = 0.35
"""Dirt from which a surface has stains that are seen one by one."""
_BRIGHTEST, _DARKEST = 0.9, 0.004
_FRESH = ("concrete", "epoxy", "steel", "wood", "kraft", "plastic")
STAINED = {name: f"{name}_worn" for name in _FRESH} | {
    "slab": "concrete_worn",
    "coat": "epoxy_worn",
    "enamel": "steel_worn",
    "liner": "kraft_worn",
}
"""Texture -> the same after years of use."""


@dataclass(frozen=True)
class Look:
    """One draw of how a kind of surface looks."""

    finish: Finish | None
    """Colour that it is painted in; None keeps the material's."""
    value: float
    hue_deg: float
    roughness: float
    dirt: float
    texture: str | None
    """Texture of another material that it has; None keeps its own."""

    @classmethod
    def of(cls, config: PaintConfig, palette: tuple[Finish, ...], rng: np.random.Generator) -> "Look":
        """Draw a look; whatever comes of it, as many numbers are sampled."""
        painted, wild, swapped = rng.random(3)
        common, free = _common(palette, rng), _any_colour(rng)
        texture = sorted(TEXTURES)[int(rng.integers(len(TEXTURES)))]
        finish = None if painted >= config.fraction else free if wild < config.any_hue else common
        return cls(
            finish=finish,
            value=config.value.sample(rng),
            hue_deg=config.hue_deg.sample(rng),
            roughness=config.roughness.sample(rng),
            dirt=config.dirt.sample(rng),
            texture=texture if swapped < config.swap else None,
        )


def coated(material: Material, look: Look, name: str, galvanised: Material) -> Material:
    """Return ``material`` in another look, under another name.

    Args:
        material: Of the catalog.
        look: How it shall look.
        name: Of the new material.
        galvanised: What bare steel looks like.
    """
    finish = look.finish
    if finish is not None and finish.bare:
        material, finish = galvanised, None
    fresh = np.array(material.base_color) if finish is None else linear_of(finish.code)
    color = np.clip(_turned(fresh, look.hue_deg) * look.value, _DARKEST, _BRIGHTEST)
    color = color + _HIDDEN * look.dirt * (_DUST - color)
    rough = float(np.clip(material.roughness * look.roughness, 0.05, 1.0))
    texture = look.texture or material.texture
    damaged = STAINED.get(texture or "") if look.dirt >= _STAINED_FROM else None
    red, green, blue = (round(float(channel), 4) for channel in color)
    return replace(
        material,
        name=name,
        base_color=(red, green, blue),
        roughness=round(rough + 0.4 * look.dirt * (1.0 - rough), 4),
        texture=damaged or texture,
        # A worn texture has the grain of the fresh one on twice the width, but for those that are as wide already.
        texture_size=material.texture_size * (1.0 if damaged is None or texture in ("slab", "coat") else 2.0),
        opacity=finish.opacity if finish is not None and finish.opacity is not None else material.opacity,
        remission=round(_remission(material, color, finish is not None), 3),
    )


def linear_of(code: str) -> np.ndarray:
    """Return the linear albedo of an sRGB colour "#RRGGBB"."""
    return linear_from_srgb(np.array([int(code[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0)


def _remission(material: Material, color: np.ndarray, painted: bool) -> float:
    """Return the remission at 905 nm of a surface that now has ``color``.

    Greys follow 0.88 sqrt(luminance), as the catalog's do within 0.05. Coloured paints send back more than their
    luminance says, since their pigments, unlike soot, are bright in near infrared: 0.38 + 0.28 R, which the catalog's
    blue, green, red, orange and yellow keep to within 0.08. What is not painted again keeps its own law.
    """
    luminance = float(LUMINANCE @ color)
    if not painted:
        was = float(LUMINANCE @ np.array(material.base_color))
        return float(np.clip(material.remission * np.sqrt(luminance / max(was, 1e-4)), 0.02, 2.0))
    grey = 0.88 * np.sqrt(luminance)
    saturation = float(np.ptp(color) / max(color.max(), 1e-4))
    pigment = max(0.38 + 0.28 * float(color[0]) - grey, 0.0)
    return float(np.clip(grey + saturation * pigment, 0.02, 0.95))


def _turned(color: np.ndarray, degrees: float) -> np.ndarray:
    """Return a linear colour with its hue turned."""
    if degrees == 0.0:
        return color
    hue, saturation, value = colorsys.rgb_to_hsv(*color)
    return np.array(colorsys.hsv_to_rgb((hue + degrees / 360.0) % 1.0, saturation, value))


def _common(palette: tuple[Finish, ...], rng: np.random.Generator) -> Finish | None:
    if not palette:
        return None
    weights = np.array([finish.weight for finish in palette])
    return palette[int(rng.choice(len(palette), p=weights / weights.sum()))]


def _any_colour(rng: np.random.Generator) -> Finish:
    hue, saturation, value = rng.random(), rng.uniform(0.04, 1.0), rng.uniform(0.25, 1.0)
    channels = colorsys.hsv_to_rgb(hue, float(saturation), value)
    return Finish("#" + "".join(f"{round(255 * channel):02X}" for channel in channels))


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
    found = {name: catalog.get(name, item) for name, item in scene.materials.items()}
    paints: dict[int, dict[str, str]] = {}
    for kind, paint in config.resolved().items():
        surface, rng = SURFACES[kind], stream(f"appearance {kind}")
        looks = _looks(surface, paint, rng)
        used = {name: _used(scene.models[name], surface) for name in {item.model for item in scene.instances}}
        chosen: dict[object, int] = {}
        for item in (item for item in scene.instances if used[item.model]):
            number = chosen.setdefault(_thing(item, surface), int(rng.integers(surface.looks)))
            for material in used[item.model]:
                these = [(f"{material} {kind} {at}", look) for at, look in enumerate(looks[material][: number + 1])]
                own = paints.setdefault(item.instance_id, dict(item.paint))
                own[material] = _coat(material, these, found, catalog)
    instances = tuple(
        replace(item, paint=paints[item.instance_id]) if item.instance_id in paints else item
        for item in scene.instances
    )
    return replace(scene, instances=instances, materials=found)


def _looks(surface: Surface, paint: PaintConfig, rng: np.random.Generator) -> dict[str, list[Look]]:
    """Draw the looks of one kind of surface in one scene, by the material that they are for."""
    apart = len(surface.materials) if surface.apart else 1
    looks = [Look.of(paint, surface.palette, rng) for _ in range(surface.looks * apart)]
    return {name: looks[place % apart :: apart] for place, name in enumerate(surface.materials)}


def _coat(
    material: str, looks: Sequence[tuple[str, Look]], found: dict[str, Material], catalog: dict[str, Material]
) -> str:
    """Return the name of ``material`` in the last of its named looks, or in one that there is where there are too many.

    A new one is added to the materials ``found``.
    """
    for name, look in reversed(looks):
        if name not in found and len(found) < MOST_MATERIALS:
            found[name] = coated(catalog[material], look, name, catalog["galvanised"])
        if name in found:
            return name
    return material


def _used(model: ObjectModel, surface: Surface) -> list[str]:
    """Return the materials of this kind of surface that a model has."""
    if surface.classes is not None and model.class_name not in surface.classes:
        return []
    return sorted({part.material for part in model.parts}.intersection(surface.materials))


def _thing(item: ObjectInstance, surface: Surface) -> object:
    """Return what shares a look with ``item``."""
    if surface.scope == "scene":
        return "scene"
    return (item.group, item.model) if surface.scope == "load" and item.group else item.instance_id
