"""Where the points of a sweep were when they were hit, and where their beams began."""

import numpy as np
from jaxtyping import Float

from warehouse_sim.dataset.formats.kitti.checks.lidar_law import LidarLaw
from warehouse_sim.dataset.stored.observation_record import RecordedObservation
from warehouse_sim.geometry.pose import Transform, transform_points

Points = Float[np.ndarray, "n 3"]


def in_world(
    points: Points,
    time: Float[np.ndarray, " n"],
    T_world_lidar: Transform,
    law: LidarLaw,
    observation: RecordedObservation,
) -> tuple[Points, Points]:
    """Return points and the starts of their beams in the world (m).

    Args:
        points: As stored, in the LiDAR's frame (m).
        time: Of each, since the sweep began (s).
        T_world_lidar: Pose of the LiDAR when it looks forward.
        law: Says whether the vehicle's motion bent the sweep, and whether it was put right.
        observation: How the vehicle moved.
    """
    hits = transform_points(T_world_lidar, points)
    starts = np.broadcast_to(T_world_lidar[:3, 3], hits.shape)
    if law.motion == "ignored":
        return hits, starts
    since = time - law.forward_time
    moved = _carried(starts, since, observation)
    return (_carried(hits, since, observation) if law.motion == "raw" else hits), moved


def _carried(points: Points, since: Float[np.ndarray, " n"], observation: RecordedObservation) -> Points:
    """Return world points that the vehicle carries, each at its time: turned about its origin, which drives an arc."""
    carrier = observation.T_world_camera if observation.T_world_vehicle is None else observation.T_world_vehicle
    pivot, rate = carrier[:3, 3], observation.yaw_rate
    # A complex number in place of the plane: dx/dt = v exp(i w t).
    velocity = complex(*observation.velocity[:2])
    turn = np.exp(1j * rate * since)
    way = velocity * (since if rate == 0 else (turn - 1.0) / (1j * rate))
    plane = (points[:, 0] - pivot[0] + 1j * (points[:, 1] - pivot[1])) * turn + way + complex(*pivot[:2])
    return np.stack([plane.real, plane.imag, points[:, 2] + observation.velocity[2] * since], axis=1)
