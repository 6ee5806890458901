"""What of a scene's light needs rays: dimming it to the wanted lux, exposing each viewpoint, measuring what is stored.

``scene.lighting`` says what the recipe requires and what stands there; the renderers turn the lights into images.
"""

from warehouse_sim.generation.light.dimming import light_scene
from warehouse_sim.generation.light.meter import LightMeter, measure_conditions, target_illuminance

__all__ = ["LightMeter", "light_scene", "measure_conditions", "target_illuminance"]
