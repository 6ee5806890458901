"""The light of a settled scene: dimmed to the lux that its recipe requires, and the camera exposed for each view."""

from dataclasses import replace

import numpy as np

from warehouse_sim.color import balanced_rgb
from warehouse_sim.errors import RecipeError
from warehouse_sim.generation.light.meter import LightMeter, following, metered_exposure
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene.lighting.config import LightingConfig
from warehouse_sim.scene.lighting.photometry import cone_of_beam, floor_points, flux_per_candela
from warehouse_sim.scene.lighting.switching import SceneLighting, sample_lighting
from warehouse_sim.schema import Light, SceneSpec, Viewpoint

FLUX = 1500.0
"""Luminous flux of one light (lm)."""
HEIGHT = 2.1
"""Of the lights above the floor (m)."""
_APART = 0.9
_BEAM_DEG = 50.0
_PITCH = np.deg2rad(-10.0)
_KELVIN = 6000.0
_RADIUS = 0.04


def work_lights(viewpoint: Viewpoint, white_balance: float) -> tuple[Light, ...]:
    """Return the two lights of the vehicle of a viewpoint, in the world.

    A camera that nothing carries is lit from above itself, as if it were carried.

    Args:
        viewpoint: Where the vehicle stands.
        white_balance: Colour temperature that the camera takes for white (K).
    """
    T_world_floor = _stand(viewpoint)
    forward, left = T_world_floor[:3, 0], T_world_floor[:3, 1]
    inner, outer = cone_of_beam(_BEAM_DEG)
    return tuple(
        Light(
            kind="spot",
            position=T_world_floor[:3, 3] + HEIGHT * T_world_floor[:3, 2] + side * _APART / 2 * left,
            direction=np.cos(_PITCH) * forward + np.sin(_PITCH) * T_world_floor[:3, 2],
            intensity=FLUX / flux_per_candela(inner, outer),
            color=balanced_rgb(_KELVIN, white_balance),
            cone_inner=inner,
            cone_outer=outer,
            radius=_RADIUS,
        )
        for side in (-1.0, 1.0)
    )


def _stand(viewpoint: Viewpoint) -> Transform:
    """Return the frame on the floor, x forward and z up, of the vehicle or under the camera."""
    if viewpoint.T_world_vehicle is not None:
        return viewpoint.T_world_vehicle
    T = viewpoint.T_world_camera
    yaw = np.arctan2(T[1, 2], T[0, 2])
    frame = np.eye(4)
    frame[:3, 0], frame[:3, 1] = [np.cos(yaw), np.sin(yaw), 0.0], [-np.sin(yaw), np.cos(yaw), 0.0]
    frame[:2, 3] = T[:2, 3]
    return frame


def light_scene(
    scene: SceneSpec, config: LightingConfig, caster: RayCaster, camera: PinholeCamera, rng: np.random.Generator
) -> SceneSpec:
    """Return a settled scene in the light of ``config``; instances, models and the viewpoints' poses stay the same.

    Lights, daylight and even light are scaled together until the aisle's floor has the wanted mean illuminance, shadows
    and light from other surfaces included. Each viewpoint gets its exposure and its vehicle's lights.

    Args:
        scene: Settled, with its final viewpoints; whatever light it has is replaced.
        config: The recipe's light with no number left open.
        caster: Rays in the scene's geometry.
        camera: What looks from the viewpoints.
        rng: Source of the light's draws; the same for paired variants that differ in a setting only.

    Raises:
        RecipeError: No light reaches the floor of the aisle, so that no lux can be reached.
    """
    lighting = sample_lighting(config, scene, floor_points(scene), rng)
    if lighting.lux is not None:
        lighting = _dimmed(lighting, lighting.lux, scene, caster)
    meter = LightMeter(lighting.applied(scene), caster)
    views = tuple(_exposed(viewpoint, lighting, meter, camera) for viewpoint in scene.viewpoints)
    if config.exposure_lag > 0:
        views = tuple(following(views, config.exposure_lag))
    # For whoever looks from elsewhere; the scene's own viewpoints have theirs.
    middle = float(np.median([view.exposure for view in views])) if views else scene.exposure
    return replace(lighting.applied(scene), exposure=middle, viewpoints=views)


def _dimmed(lighting: SceneLighting, lux: float, scene: SceneSpec, caster: RayCaster) -> SceneLighting:
    """Return the lighting scaled to a mean illuminance ``lux`` of the aisle's floor."""
    reached = LightMeter(lighting.applied(scene), caster).floor_lux
    if reached <= 0.0:
        raise RecipeError(f"lights.preset {lighting.name}: no light reaches the aisle's floor; raise lights.luminaires")
    return lighting.scaled(lux / reached)


def _exposed(viewpoint: Viewpoint, lighting: SceneLighting, meter: LightMeter, camera: PinholeCamera) -> Viewpoint:
    """Return a viewpoint with its vehicle's lights and the exposure for what it sees in them."""
    preset = lighting.preset
    lit = replace(viewpoint, lights=work_lights(viewpoint, preset.white_balance) if preset.headlights else ())
    return replace(lit, exposure=metered_exposure(meter, lit, camera, preset.exposure))
