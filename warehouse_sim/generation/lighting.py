"""The light of a settled scene: dimmed to the lux that its recipe asks for, and the camera exposed for each view."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float, Int32

from warehouse_sim.errors import RecipeError
from warehouse_sim.generation.light_meter import LightMeter, facing
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene.lighting import LightingConfig, ev_of_exposure, exposure_of_ev, floor_points
from warehouse_sim.scene.lighting.headlights import work_lights
from warehouse_sim.scene.lighting.luminaires import luminaires_of
from warehouse_sim.scene.lighting.switching import draw_lighting
from warehouse_sim.schema import Conditions, SceneSpec, Viewpoint

_COLUMNS, _ROWS = 20, 12
_CENTRE = 0.6
"""Standard deviation of the meter's weight about the image's centre, in half image sizes."""
_TARGET_POINTS = 12
"""Places on a target at which its illuminance is measured."""
_TARGET_RAYS = (4,)
_STRIDE = 3
"""Pixels from one to the next among which those of large targets are chosen."""


def light_scene(
    scene: SceneSpec, config: LightingConfig, caster: RayCaster, camera: PinholeCamera, rng: np.random.Generator
) -> SceneSpec:
    """Return a settled scene in the light of ``config``; instances, models and the viewpoints' poses stay the same.

    Lamps, daylight and even light are scaled together until the aisle's floor has the wanted mean illuminance, shadows
    and light from other surfaces included. Each viewpoint gets its exposure and its vehicle's lamps.

    Args:
        scene: Settled, with its final viewpoints; whatever light it has is replaced.
        config: The recipe's light with no number left open.
        caster: Rays in the scene's geometry.
        camera: What looks from the viewpoints.
        rng: Source of the light's draws; the same for twins that differ in a setting only.

    Raises:
        RecipeError: No lamp reaches the floor of the aisle, so that no lux can be reached.
    """
    lighting = draw_lighting(config, luminaires_of(scene), floor_points(scene), rng)
    meter = LightMeter(lighting.applied(scene, scene.exposure), caster)
    if lighting.lux is not None:
        reached = meter.floor_lux
        if reached <= 0.0:
            raise RecipeError(
                f"lights.preset {config.preset}: no lamp reaches the aisle's floor; raise lights.luminaires"
            )
        lighting = lighting.scaled(lighting.lux / reached)
        meter = LightMeter(lighting.applied(scene, scene.exposure), caster)
    preset = lighting.preset
    views = []
    for viewpoint in scene.viewpoints:
        lamps = work_lights(viewpoint, preset.white_balance) if preset.headlights else ()
        lit = replace(viewpoint, lights=lamps)
        luminance, weights = _metered(meter, lit, camera)
        views.append(replace(lit, exposure=exposure_of_ev(preset.exposure.ev_for(luminance, weights))))
    middle = float(np.median([view.exposure for view in views])) if views else scene.exposure
    return replace(lighting.applied(scene, middle), viewpoints=tuple(views))


def measure_conditions(meter: LightMeter, viewpoint: Viewpoint) -> Conditions:
    """Return what is stored of the light with an observation."""
    exposure = meter.scene.exposure if viewpoint.exposure is None else viewpoint.exposure
    return Conditions(lighting=meter.scene.lighting, floor_lux=meter.floor_lux, exposure_ev=ev_of_exposure(exposure))


def target_illuminance(
    meter: LightMeter,
    viewpoint: Viewpoint,
    camera: PinholeCamera,
    instance_ids: Int32[np.ndarray, "h w"],
    targets: Sequence[int],
) -> Mapping[int, float]:
    """Return the mean illuminance (lx) of the visible surface of each target that is visible.

    Args:
        meter: The scene's.
        viewpoint: From where it is seen; its lamps count.
        camera: With what.
        instance_ids: What it sees, as rendered.
        targets: Instance ids.
    """
    pixels = [_spread(instance_ids, target) for target in targets]
    rows = np.concatenate([np.zeros((0, 2), int), *pixels])
    owners = np.repeat(np.asarray(targets, int), [len(item) for item in pixels])
    origin, directions = _rays(viewpoint, camera, rows[:, 1], rows[:, 0])
    hits = meter.caster.cast(np.tile(origin, (len(directions), 1)), directions)
    # At an edge the ray through a pixel's centre may just miss what was rendered there.
    met = hits.instance_ids == owners
    directions, owners = directions[met], owners[met]
    points = origin + hits.distance[met, None] * directions
    normals = facing(hits.normals[met], directions)
    values = meter.illuminance(points, normals, (*meter.scene.lights, *viewpoint.lights), _TARGET_RAYS)
    return {int(target): float(values[owners == target].mean()) for target in np.unique(owners)}


def _metered(
    meter: LightMeter, viewpoint: Viewpoint, camera: PinholeCamera
) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, " n"]]:
    """Return the luminances (cd/m^2) on a grid over the image, and their weights: most in the centre."""
    x = (np.arange(_COLUMNS) + 0.5) / _COLUMNS
    y = (np.arange(_ROWS) + 0.5) / _ROWS
    u, v = (grid.ravel() for grid in np.meshgrid(x * camera.width - 0.5, y * camera.height - 0.5))
    origin, directions = _rays(viewpoint, camera, u, v)
    luminance = meter.luminance(origin, directions, (*meter.scene.lights, *viewpoint.lights))
    off_x, off_y = 2.0 * (u + 0.5) / camera.width - 1.0, 2.0 * (v + 0.5) / camera.height - 1.0
    return luminance, np.exp(-(off_x**2 + off_y**2) / (2.0 * _CENTRE**2))


def _rays(
    viewpoint: Viewpoint, camera: PinholeCamera, u: Float[np.ndarray, " n"], v: Float[np.ndarray, " n"]
) -> tuple[Float[np.ndarray, " 3"], Float[np.ndarray, "n 3"]]:
    """Return the camera's place in the world (m), and the directions through pixels."""
    T = viewpoint.T_world_camera
    return T[:3, 3], camera.rays_at(u, v) @ T[:3, :3].T


def _spread(instance_ids: Int32[np.ndarray, "h w"], target: int) -> Int32[np.ndarray, "k 2"]:
    """Return rows and columns of at most ``_TARGET_POINTS`` pixels spread evenly over those that show ``target``."""
    found = np.argwhere(instance_ids[::_STRIDE, ::_STRIDE] == target) * _STRIDE
    if len(found) < _TARGET_POINTS:
        found = np.argwhere(instance_ids == target)
    steps = np.linspace(0, len(found) - 1, min(_TARGET_POINTS, len(found))).round().astype(int)
    return found[steps]
