"""Which luminaires of a scene are on and how bright: one sample of a recipe's light, at first and when lit again."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Float

from warehouse_sim.catalog.materials import materials
from warehouse_sim.color import balanced_rgb
from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import ConfigError
from warehouse_sim.scene.lighting.config import LightingConfig, Preset
from warehouse_sim.scene.lighting.daylight import PANE, outdoors_at, pane_lights
from warehouse_sim.scene.lighting.exposure import exposure_of_ev
from warehouse_sim.scene.lighting.hall_light import failing, fill_lights
from warehouse_sim.scene.lighting.luminaires import Luminaire, luminaires_of
from warehouse_sim.scene.lighting.photometry import floor_points, luminous_flux, spot, unshadowed_illuminance
from warehouse_sim.schema import Light, Material, SceneSpec

_OPAL = (0.42, 0.42, 0.40)
"""Albedo of a luminaire's cover over dark LEDs; an estimate."""
_ROW = "led_row"
"""The catalog's material of rows of light that no light of the scene stands for."""


@dataclass(frozen=True, eq=False)
class SceneLighting:
    """All light of a hall."""

    name: str
    """Of the preset."""
    preset: Preset
    """With what the recipe says otherwise."""
    luminaires: tuple[Luminaire, ...]
    lights: tuple[Light | None, ...]
    """What each luminaire gives; None where it is off."""
    fill: tuple[Light, ...]
    """Lights of the hall beside the aisle."""
    ambient: float
    """Illuminance of the even light from above (lx)."""
    lux: float | None
    """Wanted mean illuminance of the aisle's floor (lx); None where the flux was given instead."""
    panes: float | None = None
    """Luminance of panes over that of the preset's hour, where they light the hall; None where they only glow."""

    @property
    def switched_on(self) -> tuple[Light, ...]:
        """The lights that are on, those of luminaires first."""
        return (*(light for light in self.lights if light is not None), *self.fill)

    def scaled(self, factor: float) -> "SceneLighting":
        """Return the lighting with all light ``factor`` times as strong."""
        lights = tuple(light and _scaled(light, factor) for light in self.lights)
        fill = tuple(_scaled(light, factor) for light in self.fill)
        panes = None if self.panes is None else self.panes * factor
        return replace(self, lights=lights, fill=fill, ambient=self.ambient * factor, panes=panes)

    def applied(self, scene: SceneSpec) -> SceneSpec:
        """Return ``scene`` in this light: its lights, ambient and how its luminaires look."""
        pairs, day = zip(self.luminaires, self.lights, strict=True), materials()
        faces = {item.face.material: _face_material(item, light) for item, light in pairs}
        # From the catalog's: the scene's may be those of an hour already.
        outdoors = outdoors_at(self.preset.hour, {name: day[name] for name in scene.materials if name in day})
        if self.panes is not None and PANE in outdoors:
            outdoors[PANE] = replace(outdoors[PANE], emission=outdoors[PANE].emission * self.panes)
        return replace(
            scene,
            lights=self.switched_on,
            ambient=self.ambient,
            lighting=self.name,
            materials={**scene.materials, **outdoors, **faces, **self._rows(scene)},
        )

    def _rows(self, scene: SceneSpec) -> dict[str, Material]:
        """Return how rows of light beside the aisle glow: as its luminaires do on average, or not at all."""
        row = scene.materials.get(_ROW)
        if row is None:
            return {}
        electric = [
            (item, light)
            for item, light in zip(self.luminaires, self.lights, strict=True)
            if item.face.source == "electric"
        ]
        lit = [_face_material(item, light) for item, light in electric if light is not None]
        if 2 * len(lit) < len(electric) or not lit:
            return {_ROW: replace(row, base_color=_OPAL, emission=0.0)}
        mean = sum(item.emission for item in lit) / len(electric)
        return {_ROW: replace(row, base_color=lit[0].base_color, emission=mean)}


def _scaled(light: Light, factor: float) -> Light:
    return replace(light, intensity=light.intensity * factor)


def _face_material(item: Luminaire, light: Light | None) -> Material:
    """Return how a luminous face looks: as in the catalog when it is off, else as bright as its light makes it."""
    catalog, face = materials()[item.face.catalog_material], item.face
    if light is None:
        dark = replace(catalog, name=face.material, emission=0.0)
        return replace(dark, base_color=_OPAL) if catalog.emission > 0.0 else dark
    luminance = luminous_flux(light) / (np.pi * face.area)  # of a Lambertian face
    red, green, blue = (np.array(light.color) / max(light.color)).tolist()
    return replace(catalog, name=face.material, base_color=(red, green, blue), texture=None, emission=luminance)


HANGING = ("rows", "luminaires", "mounting_height", "luminaire")
"""Settings that say where luminaires hang: geometry of the scene."""
_OF_THE_HALL = (*HANGING, "hall_fraction", "daylight")


def relit(config: LightingConfig, preset: str, settings: Mapping[str, Any], where: str) -> LightingConfig:
    """Return the light of a preset in a hall; nothing but its luminaires is kept of what was said of light before.

    Args:
        config: The light of the scene.
        preset: Name of the preset.
        settings: Any others of ``LightingConfig``.
        where: What takes them, for messages.

    Raises:
        ConfigError: A setting does not exist, does not fit, or moves luminaires.
    """
    if moved := [key for key in HANGING if key in settings]:
        raise ConfigError(
            f"{where}: {', '.join(moved)}: luminaires hang already; say it in a recipe, under scene.lights"
        )
    kept = {key: to_mapping(getattr(config, key)) for key in _OF_THE_HALL}
    return from_mapping(LightingConfig, kept | {"preset": preset} | dict(settings), where)


_FLUX = 15000.0
"""Flux of a luminaire (lm) before it is dimmed to the wanted lux: that of a high-bay luminaire of about 100 W."""
_SKY = 6500.0
"""Colour temperature of an overcast sky (K), that of CIE D65."""
_SKY_RADIUS = 2.0
"""Radius of the disk that stands for an open door as a source of light (m)."""


def sample_lighting(
    config: LightingConfig, scene: SceneSpec, floor: Float[np.ndarray, "n 3"], rng: np.random.Generator
) -> SceneLighting:
    """Draw which luminaires are on, and how bright: at the recipe's flux, or at one yet to be scaled to the wanted lux.

    Args:
        config: The recipe's light.
        scene: Its luminaires, doors and rows of light count.
        floor: Points on the aisle's floor (m), where the fraction of ambient light is counted, without shadows.
        rng: Source of all draws.
    """
    preset, luminaires = config.resolved(), luminaires_of(scene)
    lux = None if config.flux is not None else preset.lux.sample(rng)
    flux = _FLUX if config.flux is None else config.flux.sample(rng)
    if config.photometry_flux and preset.distribution is not None:
        lux, flux = None, preset.distribution.peak * preset.distribution.flux_per_candela
    lights = _electric([item for item in luminaires if item.face.source == "electric"], preset, flux, rng)
    electric = list(lights.values())
    if preset.sky_luminance > 0.0:
        lights |= {item: _daylight(item, preset) for item in luminaires if item.face.source == "daylight"}
    up = np.tile([0.0, 0.0, 1.0], (len(floor), 1))
    fill: tuple[Light, ...] = ()
    if electric and config.hall_fraction > 0.0:
        in_aisle = float(unshadowed_illuminance(electric, floor, up).mean())
        colors = list(dict.fromkeys(light.color for light in electric))
        fill = fill_lights(scene, config.hall_fraction * in_aisle, colors, preset, rng.spawn(1)[0])
    if config.daylight:
        fill += pane_lights(scene, preset)
    ambient = preset.ambient_fraction * float(unshadowed_illuminance(list(lights.values()), floor, up).mean())
    return SceneLighting(
        name=config.preset,
        preset=preset,
        luminaires=tuple(luminaires),
        lights=tuple(lights.get(item) for item in luminaires),
        fill=fill,
        ambient=ambient,
        lux=lux,
        panes=1.0 if config.daylight else None,
    )


def _electric(
    luminaires: Sequence[Luminaire], preset: Preset, flux: float, rng: np.random.Generator
) -> dict[Luminaire, Light]:
    """Return the lights of the luminaires that are on."""
    kelvins = [temperature.sample(rng) for temperature in preset.temperatures]
    rows, columns = _ranks([item.position[1] for item in luminaires]), _ranks([item.position[0] for item in luminaires])
    fractions = failing(
        [preset.pattern[column % len(preset.pattern)] for column in columns], preset.failed_fraction, rng
    )
    lights: dict[Luminaire, Light] = {}
    for item, row, column, fraction in zip(luminaires, rows, columns, fractions, strict=True):
        if fraction > 0.0:
            tone = row if max(rows) > 0 else column * len(kelvins) // (max(columns) + 1)
            tilt = preset.tilt_deg * (-1.0) ** len(lights)
            lights[item] = _spot(item, flux * fraction, kelvins[tone % len(kelvins)], tilt, preset)
    return lights


def _ranks(values: Sequence[float]) -> list[int]:
    """Return the place of each value among the different ones, to the millimetre."""
    return np.unique(np.round(values, 3), return_inverse=True)[1].tolist()


def _spot(item: Luminaire, flux: float, kelvin: float, tilt_deg: float, preset: Preset) -> Light:
    along, tilt = np.array([1.0, 0.0, 0.0]), np.deg2rad(tilt_deg)
    return spot(
        preset.distribution or preset.beam_deg,
        item.position,
        np.cos(tilt) * item.direction + np.sin(tilt) * along,
        item.length,
        flux,
        color=balanced_rgb(kelvin, preset.white_balance),
        radius=preset.source_radius,
    )


def _daylight(item: Luminaire, preset: Preset) -> Light:
    """Return the light that falls in through a door: that of the sky's luminance over its area, fading to the sides.

    A Lambertian face fades with the cosine, the widest cone of a spot with its square; on the axis they are equal.
    """
    return Light(
        kind="spot",
        position=item.position,
        direction=item.direction,
        intensity=preset.sky_luminance * item.face.area,
        color=balanced_rgb(_SKY, preset.white_balance),
        cone_inner=0.0,
        cone_outer=np.pi / 2.0,
        radius=_SKY_RADIUS,
    )


_ALBEDO = 0.2
"""Of what the camera looks at on average, before anyone has looked."""


def light_without_shadows(scene: SceneSpec, config: LightingConfig, rng: np.random.Generator) -> SceneSpec:
    """Return ``scene``, whose aisle is known, in the light of ``config``, as if nothing threw a shadow."""
    floor = floor_points(scene)
    lighting = sample_lighting(config, scene, floor, rng)
    up = np.tile([0.0, 0.0, 1.0], (len(floor), 1))
    lux = float(unshadowed_illuminance(lighting.switched_on, floor, up).mean()) + lighting.ambient
    if lighting.lux is not None and lux > 0.0:
        lighting = lighting.scaled(lighting.lux / lux)
        lux = lighting.lux or lux
    luminance = np.array([max(lux, 0.01) * _ALBEDO / np.pi])
    ev = lighting.preset.exposure.ev_for(luminance, np.ones(1))
    return replace(lighting.applied(scene), exposure=exposure_of_ev(ev))
