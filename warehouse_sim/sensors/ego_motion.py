"""The motion of the vehicle that carries a rig: it drives and turns steadily."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Float32

from warehouse_sim.schema import Viewpoint


@dataclass(frozen=True, eq=False)
class EgoMotion:
    """A steady drive on the plane: speed and yaw rate constant, so that the path is an arc."""

    velocity: Float[np.ndarray, "3"]
    """Of ``pivot`` in the world at time 0 (m/s)."""
    yaw_rate: float
    """Counter-clockwise seen from above (rad/s)."""
    pivot: Float[np.ndarray, "3"]
    """World position at time 0 of the point that has this velocity, the vehicle's origin (m)."""

    @classmethod
    def of(cls, viewpoint: Viewpoint) -> "EgoMotion | None":
        """Return the motion of a viewpoint's vehicle; None when it stands."""
        if not any(viewpoint.velocity) and viewpoint.yaw_rate == 0:
            return None
        T = viewpoint.T_world_camera if viewpoint.T_world_vehicle is None else viewpoint.T_world_vehicle
        return cls(np.asarray(viewpoint.velocity, float), viewpoint.yaw_rate, T[:3, 3].astype(float))

    def turned(self, vectors: Float[np.ndarray, "n 3"], time: Float[np.ndarray, " n"]) -> Float32[np.ndarray, "n 3"]:
        """Return world vectors that the vehicle carries, as they are at ``time`` (s)."""
        return _turn(vectors, self.yaw_rate * time)

    def moved(self, points: Float[np.ndarray, "n 3"], time: Float[np.ndarray, " n"]) -> Float32[np.ndarray, "n 3"]:
        """Return world points that the vehicle carries (m), as they are at ``time`` (s).

        The pivot follows the arc: with v turning at rate w, its way is ``v sin(wt)/w + (z x v) (1 - cos(wt))/w``.
        """
        angle = self.yaw_rate * time
        along = time * np.sinc(angle / np.pi)
        aside = time * np.sinc(angle / (2.0 * np.pi)) * np.sin(angle / 2.0)
        across = np.cross([0.0, 0.0, 1.0], self.velocity)
        way = along[:, None] * self.velocity + aside[:, None] * across
        return (_turn(points - self.pivot, angle) + self.pivot + way).astype(np.float32)


def _turn(vectors: Float[np.ndarray, "n 3"], angle: Float[np.ndarray, " n"]) -> Float32[np.ndarray, "n 3"]:
    cosine, sine = np.cos(angle), np.sin(angle)
    x, y, z = vectors.T
    return np.stack([x * cosine - y * sine, x * sine + y * cosine, z], axis=1).astype(np.float32)
