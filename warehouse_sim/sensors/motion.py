"""Motion of the vehicle that carries a rig, which drives and turns steadily, and of the cameras on it."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float, Float32

from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z
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
        pivot = viewpoint.T_world_carrier[:3, 3].astype(float)
        return cls(np.asarray(viewpoint.velocity, float), viewpoint.yaw_rate, pivot)

    def transform(self, time: float) -> Transform:
        """Return how what the vehicle carries moves in the world from time 0 to ``time`` (s)."""
        angle = self.yaw_rate * time
        along = np.sin(angle) / self.yaw_rate if self.yaw_rate else time
        aside = 2.0 * np.sin(0.5 * angle) ** 2 / self.yaw_rate if self.yaw_rate else 0.0
        way = along * self.velocity + aside * np.cross([0.0, 0.0, 1.0], self.velocity)
        R = rotation_z(angle)
        return make_transform(R, self.pivot + way - R @ self.pivot)

    def carried(
        self,
        points: Float[np.ndarray, "n 3"],
        vectors: Float[np.ndarray, "n 3"],
        time: Float[np.ndarray, " n"],
    ) -> tuple[Float32[np.ndarray, "n 3"], Float32[np.ndarray, "n 3"]]:
        """Return world points (m) and vectors that the vehicle carries, as they are at ``time`` (s).

        The pivot follows the arc: with v turning at rate w, its way is ``v sin(wt)/w + (z x v) (1 - cos(wt))/w``.
        """
        angle = self.yaw_rate * time
        cosine, sine = np.cos(angle), np.sin(angle)
        along = sine / self.yaw_rate if self.yaw_rate else time
        aside = 2.0 * np.square(np.sin(0.5 * angle)) / self.yaw_rate if self.yaw_rate else np.zeros_like(time)
        across = np.cross([0.0, 0.0, 1.0], self.velocity)
        moved = _turned(points - self.pivot.astype(points.dtype), cosine, sine)
        for component, place, v, c in zip(moved, self.pivot, self.velocity, across, strict=True):
            component += (along * float(v) + aside * float(c)) + float(place)
        return moved.T, _turned(vectors, cosine, sine).T


def _turned(
    vectors: Float[np.ndarray, "n 3"], cosine: Float[np.ndarray, " n"], sine: Float[np.ndarray, " n"]
) -> Float32[np.ndarray, "3 n"]:
    """Return components of vectors that are turned about the vertical axis, each by its own angle."""
    x, y, z = vectors.T
    turned = np.empty((3, len(x)), np.float32)
    turned[0] = x * cosine - y * sine
    turned[1] = x * sine + y * cosine
    turned[2] = z
    return turned


@dataclass(frozen=True, eq=False)
class Motion:
    """Of a camera while its shutter is open, in its own frame (x right, y down, z forward)."""

    velocity: Float[np.ndarray, "3"] = field(default_factory=lambda: np.zeros(3))
    """Of the optical centre (m/s)."""
    rotation: Float[np.ndarray, "3"] = field(default_factory=lambda: np.zeros(3))
    """Angular velocity (rad/s)."""


def camera_motion(viewpoint: Viewpoint) -> Motion:
    """Return how the camera of ``viewpoint`` moves with its vehicle, or by itself where nothing carries it."""
    T_world_camera = viewpoint.T_world_camera
    turning = np.array([0.0, 0.0, viewpoint.yaw_rate])
    lever = T_world_camera[:3, 3] - viewpoint.T_world_carrier[:3, 3]
    R_camera_world = T_world_camera[:3, :3].T
    velocity = np.asarray(viewpoint.velocity) + np.cross(turning, lever)
    return Motion(R_camera_world @ velocity, R_camera_world @ turning)
