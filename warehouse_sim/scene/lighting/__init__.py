"""Lamps in lumen and kelvin, presets of light, and how the camera is exposed for them."""

from warehouse_sim.scene.lighting.config import LightingConfig
from warehouse_sim.scene.lighting.exposure import ExposureConfig, ev_of_exposure, exposure_of_ev
from warehouse_sim.scene.lighting.floor import floor_points
from warehouse_sim.scene.lighting.presets import PRESETS, PresetName
from warehouse_sim.scene.lighting.unsettled import add_fixtures, first_light

__all__ = [
    "PRESETS",
    "ExposureConfig",
    "LightingConfig",
    "PresetName",
    "add_fixtures",
    "ev_of_exposure",
    "exposure_of_ev",
    "first_light",
    "floor_points",
]
