"""All the light of one scene: what each fixture gives, and how that makes the scene look."""

from dataclasses import dataclass, replace

import numpy as np

from warehouse_sim.catalog import materials
from warehouse_sim.scene.lighting.fixtures import Fixture
from warehouse_sim.scene.lighting.photometry import luminous_flux
from warehouse_sim.scene.lighting.presets import Preset
from warehouse_sim.schema import Light, Material, SceneSpec

_OPAL = (0.42, 0.42, 0.40)
"""Albedo of a luminaire's cover over dark LEDs; an estimate."""
_BRIGHTEST = 50.0
"""Image value at which a glow is cut; white begins at about 4."""


@dataclass(frozen=True, eq=False)
class Installation:
    """All light of a hall."""

    name: str
    """Of the preset."""
    preset: Preset
    """With what the recipe says otherwise."""
    fixtures: tuple[Fixture, ...]
    lights: tuple[Light | None, ...]
    """What each fixture gives; None where it is dark."""
    ambient: float
    """Illuminance of the even light from above (lx)."""
    lux: float | None
    """Wanted mean illuminance of the aisle's floor (lx); None where the flux was given instead."""

    @property
    def burning(self) -> tuple[Light, ...]:
        """The lamps that give light."""
        return tuple(light for light in self.lights if light is not None)

    def scaled(self, factor: float) -> "Installation":
        """Return the installation with all light ``factor`` times as strong."""
        lights = tuple(light and replace(light, intensity=light.intensity * factor) for light in self.lights)
        return replace(self, lights=lights, ambient=self.ambient * factor)

    def applied(self, scene: SceneSpec, exposure: float) -> SceneSpec:
        """Return ``scene`` in this light: lamps, ambient, exposure and how its fixtures look."""
        pairs = zip(self.fixtures, self.lights, strict=True)
        glows = {item.material: _glow(item, light, exposure) for item, light in pairs}
        return replace(
            scene,
            lights=self.burning,
            ambient=self.ambient,
            exposure=exposure,
            lighting=self.name,
            materials={**scene.materials, **glows},
        )


def _glow(fixture: Fixture, light: Light | None, exposure: float) -> Material:
    """Return how the face of a fixture looks: as in the catalog when dark, else as bright as its light makes it."""
    catalog = materials()[fixture.catalog_material]
    if light is None:
        dark = replace(catalog, name=fixture.material, emission=0.0)
        return replace(dark, base_color=_OPAL) if catalog.emission > 0.0 else dark
    luminance = luminous_flux(light) / (np.pi * fixture.area)  # of a Lambertian face
    red, green, blue = (np.array(light.color) / max(light.color)).tolist()
    emission = min(luminance * exposure, _BRIGHTEST)
    return replace(
        catalog,
        name=fixture.material,
        base_color=(red, green, blue),
        texture=None,
        emission=emission,
    )
