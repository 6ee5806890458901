"""The colour of the light that falls on what a camera sees, and the gains by which it takes most of the cast away."""

import numpy as np
from jaxtyping import Float, UInt8

from warehouse_sim.color import LUMINANCE, linear_from_srgb
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.display import inverse_tone_map
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import SceneSpec

Rgb = tuple[float, float, float]
WHITE: Rgb = (1.0, 1.0, 1.0)

_COLUMNS, _ROWS = 20, 12
"""Places of an image at which its light is taken."""
_DARK, _BRIGHT = 0.002, 0.9
"""Image values of pixels that say nothing of the colour of their light."""
_MATT = 0.5
"""Metals of more than this mirror colours of other things."""


def light_color(
    scene: SceneSpec,
    caster: RayCaster,
    camera: PinholeCamera,
    T_world_camera: Transform,
    rgb: UInt8[np.ndarray, "h w 3"],
) -> Rgb:
    """Return the colour, of unit luminance, of the light on what is seen; white where nothing tells.

    What an image shows over what its surfaces return of white light, on a grid of pixels: a camera that would mistake
    no brown carton for warm light.

    Args:
        scene: What is seen.
        caster: Rays in its geometry.
        camera: Intrinsics and lens.
        T_world_camera: Its pose.
        rgb: The clean image.
    """
    u = (2 * np.arange(_COLUMNS) + 1) * camera.width // (2 * _COLUMNS)
    v = (2 * np.arange(_ROWS) + 1) * camera.height // (2 * _ROWS)
    u, v = (grid.ravel() for grid in np.meshgrid(u, v))
    rays = camera.rays_at(u, v) @ T_world_camera[:3, :3].T
    hits = caster.cast(np.tile(T_world_camera[:3, 3], (len(rays), 1)), rays)
    # One more row answers for rays that meet nothing, whose material is -1.
    met = [scene.materials[name] for name in caster.materials]
    tells = np.array([*(item.emission == 0.0 and item.metallic < _MATT for item in met), False])
    albedo = np.array([*(item.base_color for item in met), (0.0, 0.0, 0.0)])[hits.materials]
    shown = inverse_tone_map(linear_from_srgb(rgb[v, u] / 255.0))
    counted = tells[hits.materials] & (shown.max(axis=1) < _BRIGHT) & (shown.min(axis=1) > _DARK)
    total = shown[counted].sum(axis=0) / np.maximum(albedo[counted].sum(axis=0), 1e-6)
    luminance = float(LUMINANCE @ total)
    return WHITE if luminance <= 0.0 else _rgb(total / luminance)


def balancing(light: Rgb, fraction: float) -> Float[np.ndarray, " 3"]:
    """Return the gains of the channels that take ``fraction`` of the cast of ``light`` away and leave its luminance.

    The cast is that of the logarithms of the channels over green: a lamp is as far from white as its gains.
    """
    color = np.asarray(light, float)
    gains = (color[1] / color) ** fraction
    return gains * float(LUMINANCE @ color) / float(LUMINANCE @ (gains * color))


def _rgb(values: Float[np.ndarray, " 3"]) -> Rgb:
    red, green, blue = (float(value) for value in values)
    return red, green, blue
