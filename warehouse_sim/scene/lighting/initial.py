"""Light for a scene that has just been sampled, by formulas alone; shadows are counted in when it has settled."""

from dataclasses import replace

import numpy as np

from warehouse_sim.scene.lighting.config import LightingConfig
from warehouse_sim.scene.lighting.exposure import exposure_of_ev
from warehouse_sim.scene.lighting.floor import floor_points
from warehouse_sim.scene.lighting.photometry import unshadowed_illuminance
from warehouse_sim.scene.lighting.switching import draw_lighting
from warehouse_sim.schema import SceneSpec

_ALBEDO = 0.2
"""Of what the camera looks at on average, before anyone has looked."""


def light_without_shadows(scene: SceneSpec, config: LightingConfig, rng: np.random.Generator) -> SceneSpec:
    """Return ``scene``, whose aisle is known, in the light of ``config``, as if nothing threw a shadow."""
    floor = floor_points(scene)
    lighting = draw_lighting(config, scene, floor, rng)
    up = np.tile([0.0, 0.0, 1.0], (len(floor), 1))
    lux = float(unshadowed_illuminance(lighting.switched_on, floor, up).mean()) + lighting.ambient
    if lighting.lux is not None and lux > 0.0:
        lighting = lighting.scaled(lighting.lux / lux)
        lux = lighting.lux or lux
    luminance = np.array([max(lux, 0.01) * _ALBEDO / np.pi])
    ev = lighting.preset.exposure.ev_for(luminance, np.ones(1))
    return replace(lighting.applied(scene), exposure=exposure_of_ev(ev))
