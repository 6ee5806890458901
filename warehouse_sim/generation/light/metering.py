"""What a camera meters from a viewpoint, and the exposure that follows."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from warehouse_sim.generation.light.meter import LightMeter
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.scene.lighting import ExposureConfig, ev_of_exposure, exposure_of_ev
from warehouse_sim.schema import Viewpoint

_COLUMNS, _ROWS = 20, 12
_CENTRE = 0.6
"""Standard deviation of the meter's weight about the image's centre, in half image sizes."""


def metered_exposure(meter: LightMeter, viewpoint: Viewpoint, camera: PinholeCamera, config: ExposureConfig) -> float:
    """Return the exposure (linear image value of 1 cd/m^2) of a viewpoint, from rays on a grid over its image.

    Args:
        meter: The scene's.
        viewpoint: Where the camera stands; its vehicle's lights count.
        camera: What looks.
        config: How it is exposed.
    """
    x = (np.arange(_COLUMNS) + 0.5) / _COLUMNS
    y = (np.arange(_ROWS) + 0.5) / _ROWS
    u, v = (grid.ravel() for grid in np.meshgrid(x * camera.width - 0.5, y * camera.height - 0.5))
    origin, directions = rays_through(viewpoint, camera, u, v)
    luminance = meter.luminance(origin, directions, (*meter.scene.lights, *viewpoint.lights))
    off_x, off_y = 2.0 * (u + 0.5) / camera.width - 1.0, 2.0 * (v + 0.5) / camera.height - 1.0
    weights = np.exp(-(off_x**2 + off_y**2) / (2.0 * _CENTRE**2))
    return exposure_of_ev(config.ev_for(luminance, weights))


def following(views: Iterable[Viewpoint], lag: float) -> Iterator[Viewpoint]:
    """Yield viewpoints with the exposure of a camera that follows its meter late within each drive.

    The exposure value goes towards the metered one by ``1 - exp(-dt / lag)`` of the difference, as a discrete filter of
    first order; the first image of a drive is as it was metered.

    Args:
        views: With their metered exposures; those of a drive in order of time.
        lag: Time constant (s), > 0.
    """
    before: dict[int, tuple[float, float]] = {}
    for view in views:
        if view.sequence is None or view.exposure is None:
            yield view
            continue
        ev = ev_of_exposure(view.exposure)
        if view.sequence in before:
            time, last = before[view.sequence]
            ev = last + (ev - last) * -float(np.expm1(-(view.time - time) / lag))
        before[view.sequence] = view.time, ev
        yield replace(view, exposure=exposure_of_ev(ev))


def rays_through(
    viewpoint: Viewpoint, camera: PinholeCamera, u: Float[np.ndarray, " n"], v: Float[np.ndarray, " n"]
) -> tuple[Float[np.ndarray, " 3"], Float[np.ndarray, "n 3"]]:
    """Return the camera's place in the world (m), and the directions through pixels."""
    T = viewpoint.T_world_camera
    return T[:3, 3], camera.rays_at(u, v) @ T[:3, :3].T
