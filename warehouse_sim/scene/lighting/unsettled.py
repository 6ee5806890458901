"""Light for a scene that has just been drawn, by formulas alone; shadows are counted in when it has settled."""

import numpy as np

from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.layouts.site import Site
from warehouse_sim.scene.lighting.config import LightingConfig
from warehouse_sim.scene.lighting.exposure import exposure_of_ev
from warehouse_sim.scene.lighting.fixtures import add_doors, fixtures_of, hang_luminaires
from warehouse_sim.scene.lighting.floor import floor_points
from warehouse_sim.scene.lighting.photometry import unshaded_illuminance
from warehouse_sim.scene.lighting.switching import install
from warehouse_sim.schema import SceneSpec

_ALBEDO = 0.2
"""Of what the camera looks at on average, before anyone has looked."""


def add_fixtures(draft: SceneDraft, config: LightingConfig, site: Site) -> None:
    """Hang the luminaires and add the doors."""
    hang_luminaires(draft, config.rows, config.luminaires, config.mounting_height, site.aisle)
    add_doors(draft, site.aisle, site.hall)


def first_light(scene: SceneSpec, config: LightingConfig, rng: np.random.Generator) -> SceneSpec:
    """Return ``scene``, whose aisle is known, in the light of ``config``, as if nothing threw a shadow."""
    floor = floor_points(scene)
    installation = install(config, fixtures_of(scene), floor, rng)
    up = np.tile([0.0, 0.0, 1.0], (len(floor), 1))
    lux = float(unshaded_illuminance(installation.burning, floor, up).mean()) + installation.ambient
    if installation.lux is not None and lux > 0.0:
        installation = installation.scaled(installation.lux / lux)
        lux = installation.lux or lux
    luminance = np.array([max(lux, 0.01) * _ALBEDO / np.pi])
    ev = installation.preset.exposure.ev_for(luminance, np.ones(1))
    return installation.applied(scene, exposure_of_ev(ev))
