"""What a recipe says of light, the luminaires that stand for it, and the formulas between lumen, candela, lux and EV.

Nothing here needs rays: shadows, bounced light and what a camera meters are in ``generation.light``.
"""

from warehouse_sim.scene.lighting.config import LightingConfig
from warehouse_sim.scene.lighting.exposure import ExposureConfig, ev_of_exposure, exposure_of_ev
from warehouse_sim.scene.lighting.luminaires import add_luminaires
from warehouse_sim.scene.lighting.photometry import floor_points
from warehouse_sim.scene.lighting.presets import PRESETS, PresetName
from warehouse_sim.scene.lighting.switching import light_without_shadows

__all__ = [
    "PRESETS",
    "ExposureConfig",
    "LightingConfig",
    "PresetName",
    "add_luminaires",
    "ev_of_exposure",
    "exposure_of_ev",
    "floor_points",
    "light_without_shadows",
]
