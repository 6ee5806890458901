"""An EPAL 1 pallet reduced to what scores need, and poses to try on it."""

import numpy as np

from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.pose import level_camera, make_transform, rotation_x, rotation_y, rotation_z
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.schema import Pocket

SIZE = np.array([1.2, 0.8, 0.144])
SYMMETRY = SymmetryGroup.turns("z", 2)


def pockets() -> tuple[Pocket, ...]:
    """The eight openings: two on each side, 227.5 mm wide on the 800 sides, 382.5 mm on the 1200 sides."""
    sides = {
        "-x": (0.0, 0.6, 0.18625, [1.2, 0.2275, 0.100], 0.050),
        "+x": (np.pi, 0.6, 0.18625, [1.2, 0.2275, 0.100], 0.050),
        "-y": (np.pi / 2, 0.4, 0.26375, [0.8, 0.3825, 0.100], 0.072),
        "+y": (-np.pi / 2, 0.4, 0.26375, [0.8, 0.3825, 0.100], 0.072),
    }
    made = []
    for face, (yaw, reach, aside, size, height) in sides.items():
        for sign in (-1.0, 1.0):
            opening = rotation_z(yaw) @ [-reach, sign * aside, 0.0] + [0.0, 0.0, height - SIZE[2] / 2]
            made.append(Pocket(face, make_transform(rotation_z(yaw), opening), np.array(size)))
    return tuple(made)


def surface() -> np.ndarray:
    """A grid over the outer box, closed under the half-turn about z."""
    axis = np.linspace(-0.5, 0.5, 9)
    grid = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    return grid[np.abs(grid).max(axis=1) == 0.5] * SIZE


def seen_from(distance: float, yaw: float = 0.0, height: float = 0.3) -> np.ndarray:
    """T_camera_object of a pallet ahead of a level camera that looks along world +x; yaw 0 shows its -x side."""
    T_world_object = make_transform(rotation_z(yaw), np.array([distance, 0.0, 0.0]))
    return np.linalg.inv(level_camera(np.array([0.0, 0.0, height]), 0.0)) @ T_world_object


def nudge(x: float = 0.0, y: float = 0.0, z: float = 0.0, roll: float = 0.0, pitch: float = 0.0, yaw: float = 0.0):
    """A small motion in the object frame (m, rad)."""
    return make_transform(rotation_z(yaw) @ rotation_y(pitch) @ rotation_x(roll), np.array([x, y, z]))


def random_motion(rng: np.random.Generator, angle: float, offset: float) -> np.ndarray:
    """A motion by at most ``angle`` about each axis and ``offset`` along each."""
    roll, pitch, yaw = rng.uniform(-angle, angle, 3)
    return nudge(*rng.uniform(-offset, offset, 3), roll, pitch, yaw)


CORNERS = box_corners(SIZE)
