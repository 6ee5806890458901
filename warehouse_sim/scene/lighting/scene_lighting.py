"""All the light of one scene: what each luminaire gives, and how that makes the scene look."""

from dataclasses import dataclass, replace

import numpy as np

from warehouse_sim.catalog.materials import materials
from warehouse_sim.scene.lighting.daylight import outdoors_at
from warehouse_sim.scene.lighting.luminaires import Luminaire
from warehouse_sim.scene.lighting.panes import PANE
from warehouse_sim.scene.lighting.photometry import luminous_flux
from warehouse_sim.scene.lighting.presets import Preset
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
            materials={
                **scene.materials,
                **outdoors,
                **faces,
                **self._rows(scene),
            },
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
