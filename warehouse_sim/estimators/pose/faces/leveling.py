"""Which way is down, and how sure that is: given, seen on the floor, or supposed."""

from dataclasses import dataclass

import numpy as np

from warehouse_sim.estimators.gravity import Direction, down_from_floor
from warehouse_sim.estimators.pose.faces.settings import FaceConfig
from warehouse_sim.estimators.rgbd_image import RgbdImage

_LOOKS = 3
"""The floor is looked for so often, each time on other readings; where it is no plane, as a mirror is, they differ."""


@dataclass(frozen=True, eq=False)
class Leveling:
    """Gravity in the camera frame."""

    down: Direction
    sigma: float
    """Standard deviation about each horizontal axis (rad)."""


def find_down(image: RgbdImage, config: FaceConfig, rng: np.random.Generator) -> Leveling:
    """Return gravity as the image brings it, else as the floor has it, else that of a level camera."""
    if config.gravity and image.gravity is not None:
        return Leveling(np.asarray(image.gravity, dtype=float), np.deg2rad(config.gravity_deg))
    seen = [down_from_floor(image.camera, image.depth, rng) for _ in range(_LOOKS)]
    found = [down for down in seen if down is not None]
    if len(found) < _LOOKS:
        return Leveling(np.array([0.0, 1.0, 0.0]), np.deg2rad(config.level_deg))
    mean = np.mean(found, axis=0)
    mean /= np.linalg.norm(mean)
    spread = float(np.sqrt(np.mean([np.sum((down - mean) ** 2) for down in found])))
    sigma = float(np.hypot(np.deg2rad(config.floor_deg), 1.5 * spread))
    return Leveling(mean, min(sigma, np.deg2rad(config.level_deg)))
