"""The colour of the light that falls on what a camera sees, and the gains by which it takes most of the cast away."""

import numpy as np
from jaxtyping import Float, Float32

from warehouse_sim.color import LUMINANCE
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, transform_points
from warehouse_sim.render.light_selection import even_illuminance
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene.lighting.photometry import relative_intensity
from warehouse_sim.schema import Light, SceneSpec

Rgb = tuple[float, float, float]
WHITE: Rgb = (1.0, 1.0, 1.0)

_COLUMNS, _ROWS = 8, 6
"""Places of an image at which its light is taken."""
_NEAREST = 0.5
"""Nearest distance to a light (m): a lamp in view does not outshine all that it lights."""
_LIFT = 0.99
"""Fraction of the way from the camera to a surface at which its light is taken."""


def light_color(
    scene: SceneSpec,
    caster: RayCaster,
    camera: PinholeCamera,
    T_world_camera: Transform,
    depth: Float32[np.ndarray, "h w"],
) -> Rgb:
    """Return the colour, of unit luminance, of the direct light on what is seen; white where there is none.

    Args:
        scene: In the light of the moment; its even light is white.
        caster: Rays in its geometry, for shadows.
        camera: Intrinsics and lens.
        T_world_camera: Its pose.
        depth: True z-depth (m), 0 = infinitely far.
    """
    height, width = depth.shape
    u, v = ((np.arange(count) * size + size // 2) // count for count, size in ((_COLUMNS, width), (_ROWS, height)))
    u, v = (grid.ravel() for grid in np.meshgrid(u, v))
    z = depth[v, u].astype(float)
    rays, seen = camera.rays_at(u, v), z > 0
    points = transform_points(T_world_camera, _LIFT * z[seen, None] * rays[seen])
    total = np.full(3, even_illuminance(scene) * len(points))
    for light in scene.lights:
        total += _given(light, caster, points) * np.asarray(light.color)
    luminance = float(LUMINANCE @ total)
    return WHITE if luminance <= 0.0 else _rgb(total / luminance)


def _given(light: Light, caster: RayCaster, points: Float[np.ndarray, "n 3"]) -> float:
    """Return the sum of illuminances (lx) that a light gives to surfaces at ``points`` (m) which face it."""
    to_light = np.asarray(light.position, float) - points
    distance = np.maximum(np.linalg.norm(to_light, axis=1), _NEAREST)
    towards = to_light / distance[:, None]
    values = relative_intensity(light, -towards @ np.asarray(light.direction, float), -towards) / distance**2
    lit = np.flatnonzero(values > 0.0)
    if light.casts_shadow and len(lit):
        lit = lit[caster.cast(points[lit], to_light[lit]).distance >= 1.0]
    return light.intensity * float(values[lit].sum())


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
