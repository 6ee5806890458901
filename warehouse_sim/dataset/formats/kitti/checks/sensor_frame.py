"""The frame of stored points, which is level, and that of the LiDAR that measured them, which may lean."""

import numpy as np
from jaxtyping import Float

from warehouse_sim.dataset.checks.findings import Findings
from warehouse_sim.dataset.stored.observation_record import RecordedObservation
from warehouse_sim.geometry.pose import Transform, invert, transform_points

_LARGEST_LEAN = np.deg2rad(2.0) + 1e-6
_SAME_PLACE = 1e-5


def as_measured(
    points: Float[np.ndarray, "n 3"], T_world_points: Transform, observation: RecordedObservation
) -> Float[np.ndarray, "n 3"]:
    """Return stored points (m) in the frame of the LiDAR itself."""
    if observation.T_camera_lidar is None:
        return points
    T_lidar_points = invert(observation.T_world_camera @ observation.T_camera_lidar) @ T_world_points
    return transform_points(T_lidar_points, points.astype(float))


def is_level(findings: Findings, T_world_points: Transform, observation: RecordedObservation, where: str) -> None:
    """Require that z is up in the frame of stored points, and that it is where the LiDAR is, if that leans."""
    leaning = float(np.arccos(np.clip(T_world_points[2, 2], -1.0, 1.0)))
    findings.require(
        leaning <= _LARGEST_LEAN, f"{where}: the z axis of the points leans by {np.rad2deg(leaning):.2f} deg"
    )
    if observation.T_camera_lidar is not None:
        T_world_lidar = observation.T_world_camera @ observation.T_camera_lidar
        apart = float(np.abs(T_world_lidar[:3, 3] - T_world_points[:3, 3]).max())
        findings.require(apart < _SAME_PLACE, f"{where}: the LiDAR of the scene record is {apart:.6f} m from there")
