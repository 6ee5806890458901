"""How an image is captured: with which camera, exposure and motion, and of which materials."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.schema import Viewpoint
from warehouse_sim.sensors.film import FilmImage
from warehouse_sim.sensors.surfaces import Surfaces


@dataclass(frozen=True, eq=False)
class Motion:
    """Of a camera while its shutter is open, in its own frame (x right, y down, z forward)."""

    velocity: Float[np.ndarray, "3"] = field(default_factory=lambda: np.zeros(3))
    """Of the optical centre (m/s)."""
    rotation: Float[np.ndarray, "3"] = field(default_factory=lambda: np.zeros(3))
    """Angular velocity (rad/s)."""


@dataclass(frozen=True, eq=False)
class Capture:
    """One image of a camera."""

    camera: PinholeCamera
    exposure_ev: float | None = None
    """Exposure value at ISO 100 that the image was rendered for; None = enough light for the least gain."""
    motion: Motion = field(default_factory=Motion)
    surfaces: Surfaces | None = None
    """Materials of the pixels, for depth models that need them."""
    film: FilmImage | None = None
    """Stretch film before the pixels, for depth models that see it; None = none in view."""


def camera_motion(viewpoint: Viewpoint) -> Motion:
    """Return how the camera of ``viewpoint`` moves with its vehicle, or by itself where nothing carries it."""
    T_world_camera = viewpoint.T_world_camera
    turning = np.array([0.0, 0.0, viewpoint.yaw_rate])
    lever = T_world_camera[:3, 3] - viewpoint.T_world_carrier[:3, 3]
    R_camera_world = T_world_camera[:3, :3].T
    velocity = np.asarray(viewpoint.velocity) + np.cross(turning, lever)
    return Motion(R_camera_world @ velocity, R_camera_world @ turning)
