"""Iterative closest point against the CAD surface: the last centimetres that a network leaves.

Point-to-plane (Chen and Medioni, 1992) on the distance field of the surface that faces the camera, in a space squashed
along the viewing direction by the ratio of the sensor's errors, with an annealed gate, Cauchy weights, and a prior at
the network's pose for the directions that the visible points do not fix.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from warehouse_sim.estimators.surface import CadSurface, SeenSurface
from warehouse_sim.geometry.pose import Transform, invert, make_transform, rotation_angle, transform_points

_MAD_TO_SIGMA = 1.4826
"""Standard deviation of a normal variable over its median absolute deviation."""


@dataclass(frozen=True)
class IcpConfig:
    """How a pose is fitted to its points."""

    looks: int = 3
    """How often it is decided anew what the camera sees and how noisy it is, >= 1."""
    iterations: int = 4
    """Steps after each look, >= 1."""
    points: int = 600
    """Most points used after the last look, >= 12; before, a third of them."""
    gate_start: float = 0.15
    """Points farther from the surface are ignored in the first step (squashed m), > 0."""
    gate_end: float = 0.03
    """The same in the last step (squashed m), > 0; three times the noise of the points where that is more."""
    cauchy: float = 0.015
    """Distance at which a point loses half its weight (squashed m), > 0; the noise of the points where that is more."""
    lateral_noise: float = 0.004
    """Error of points across the viewing direction (m), > 0; about half a pixel."""
    squash_start: float = 0.5
    """Assumed ratio of the errors across and along the viewing direction after the first look, 0-1."""
    squash_least: float = 0.1
    """Smallest ratio that is believed when it is measured, 0-1."""
    prior_shift: float = 0.05
    """Standard deviation of the network's position (m), > 0."""
    prior_turn: float = 0.05
    """Standard deviation of the network's rotation (rad), > 0."""
    most_shift: float = 0.25
    """A result farther from the network's position than this (m) is rejected, > 0."""
    most_turn: float = 0.35
    """A result turned farther than this (rad) is rejected, > 0."""


def refine_pose(
    T_camera_object: Transform, points: Float[np.ndarray, "n 3"], surface: CadSurface, config: IcpConfig
) -> Transform:
    """Return the pose that fits ``points`` to the surface, or the given one where the fit does not get better.

    Args:
        T_camera_object: Pose to start from.
        points: What the camera sees of the object (camera frame, m), in random order.
        surface: CAD surface of the object.
        config: Settings.
    """
    points = np.asarray(points[: config.points], dtype=float)
    T, delta, squash, step = T_camera_object, np.zeros(6), config.squash_start, 0
    visible = surface.seen_from(invert(T)[:3, 3], squash)
    for look in range(config.looks):
        used = points if look == config.looks - 1 else points[: max(config.points // 3, 6)]
        if look > 0:
            squash = _measure_squash(transform_points(invert(T), used), visible, squash, config)
            visible = surface.seen_from(invert(T)[:3, 3], squash)
        for _ in range(config.iterations):
            change = _gauss_newton(transform_points(invert(T), used), visible, delta, _gate(config, step), config)
            delta, step = delta + change, step + 1
            # The step moves the points in the object frame; the object moves the other way.
            T = T @ invert(make_transform(Rotation.from_rotvec(change[:3]).as_matrix(), change[3:]))
    return T if _is_better(T, T_camera_object, points, surface, squash, config) else T_camera_object


def misfit(
    T_camera_object: Transform, points: Float[np.ndarray, "n 3"], surface: CadSurface, squash: float, gate: float
) -> float:
    """Return the mean squashed distance (m) of the points to the surface that faces the camera, each at most ``gate``.

    Args:
        T_camera_object: Pose to judge.
        points: What the camera sees of the object (camera frame, m).
        surface: CAD surface of the object.
        squash: Noise across the viewing direction over noise along it, 0-1.
        gate: Distance from which points count the same (m).
    """
    T_object_camera = invert(T_camera_object)
    distance, _ = surface.seen_from(T_object_camera[:3, 3], squash).nearest(transform_points(T_object_camera, points))
    return float(np.minimum(np.abs(distance), gate).mean())


def _measure_squash(points: Float[np.ndarray, "n 3"], visible: SeenSurface, squash: float, config: IcpConfig) -> float:
    distance, _ = visible.nearest(points)
    # Most of the surface is seen frontally, where a squashed distance is one along the ray times the squash.
    along_ray = _MAD_TO_SIGMA * float(np.median(np.abs(distance))) / squash
    return float(np.clip(config.lateral_noise / max(along_ray, 1e-6), config.squash_least, 1.0))


def _gate(config: IcpConfig, step: int) -> float:
    share = step / max(1, config.looks * config.iterations - 1)
    return config.gate_start * (config.gate_end / config.gate_start) ** share


def _gauss_newton(
    points: Float[np.ndarray, "n 3"],
    visible: SeenSurface,
    delta: Float[np.ndarray, " 6"],
    gate: float,
    config: IcpConfig,
) -> Float[np.ndarray, " 6"]:
    """Return the small motion (rotation vector, shift) of the points that brings them closer to the surface.

    Args:
        points: Object frame (m).
        visible: Part of the CAD surface that faces the camera.
        delta: Sum of the motions so far, which the prior pulls back to zero.
        gate: Largest distance that counts (squashed m).
        config: Settings.
    """
    distance, direction = visible.nearest(points)
    noise = max(_MAD_TO_SIGMA * float(np.median(np.abs(distance))), 1e-3)
    scale = max(config.cauchy, noise)
    weight = (np.abs(distance) <= max(gate, 3.0 * noise)) / (1.0 + (distance / scale) ** 2)
    jacobian = np.concatenate([np.cross(points, direction), direction], axis=1)
    weighted = (jacobian * weight[:, None]).T
    precision = noise**2 / np.array([config.prior_turn] * 3 + [config.prior_shift] * 3) ** 2
    return np.linalg.solve(weighted @ jacobian + np.diag(precision), -weighted @ distance - precision * delta)


def _is_better(
    T: Transform,
    T_start: Transform,
    points: Float[np.ndarray, "n 3"],
    surface: CadSurface,
    squash: float,
    config: IcpConfig,
) -> bool:
    shift = float(np.linalg.norm(T[:3, 3] - T_start[:3, 3]))
    turn = float(rotation_angle(T[:3, :3], T_start[:3, :3]))
    if shift > config.most_shift or turn > config.most_turn:
        return False
    before, after = (misfit(pose, points, surface, squash, config.gate_start) for pose in (T_start, T))
    return after < before
