"""What is known of the pose of an object that stands still: a Kalman filter in information form.

An estimate's error is taken for the sum of one that is its own and one that all estimates fraction (a unit's bias, the
CAD model, the mounting). Only the first is averaged. The second is considered, not estimated (Schmidt 1966): it goes
into the covariance as what the weighted mean makes of it, in full correlation.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from warehouse_sim.geometry.pose import Transform, make_transform

Vector6 = Float[np.ndarray, " 6"]
Matrix6 = Float[np.ndarray, "6 6"]


@dataclass(frozen=True, eq=False)
class Measurement:
    """One estimate in the world frame; errors are of (x, y, z, about x, about y, about z) along the world's axes."""

    T_world_object: Transform
    own: Matrix6
    """Covariance of the error that is its own (m, rad)."""
    common: Float[np.ndarray, "6 c"]
    """What each of c common errors of unit variance does to it (m, rad)."""

    @property
    def covariance(self) -> Matrix6:
        """Of both together."""
        return np.asarray(self.own + self.common @ self.common.T)


@dataclass(frozen=True, eq=False)
class Belief:
    """The pose of one object after some measurements."""

    T_world_object: Transform
    information: Matrix6
    """Inverse covariance of what is averaged."""
    common: Float[np.ndarray, "6 c"]
    """Sum of each measurement's information times what the common errors do to it."""

    @classmethod
    def of(cls, first: Measurement) -> "Belief":
        """Return what one measurement says."""
        information = np.linalg.inv(first.own)
        return cls(first.T_world_object, information, information @ first.common)

    @property
    def covariance(self) -> Matrix6:
        """Of the pose, common errors included."""
        return np.asarray(np.linalg.inv(self.information) + self.shared @ self.shared.T)

    @property
    def shared(self) -> Float[np.ndarray, "6 c"]:
        """What each common error of unit variance does to the pose."""
        return np.asarray(np.linalg.solve(self.information, self.common))

    def apart(self, measurement: Measurement) -> Matrix6:
        """Return the covariance of the difference between a measurement and this: what both share falls out of it."""
        unlike = measurement.common - self.shared
        return np.asarray(np.linalg.inv(self.information) + measurement.own + unlike @ unlike.T)

    def updated(self, measurement: Measurement, weight: float = 1.0) -> "Belief":
        """Return what is known after one more measurement.

        Args:
            measurement: Its pose must be that of the symmetric equivalents that is nearest to this one.
            weight: By which its information is multiplied, 0-1.
        """
        added = weight * np.linalg.inv(measurement.own)
        information = self.information + added
        step = np.linalg.solve(information, added @ difference(measurement.T_world_object, self.T_world_object))
        return Belief(moved(self.T_world_object, step), information, self.common + added @ measurement.common)

    def after(self, variance: float) -> "Belief":
        """Return the belief when the place has become less certain by a variance (m^2) along each axis."""
        if variance == 0.0:
            return self
        shared, own = self.shared, np.linalg.inv(self.information)
        own[:3, :3] += np.eye(3) * variance
        information = np.linalg.inv(own)
        return replace(self, information=information, common=information @ shared)


def difference(T_world_a: Transform, T_world_b: Transform) -> Vector6:
    """Return the small motion (m, rad) that brings pose b to pose a: of its origin, and about it."""
    turn = Rotation.from_matrix(T_world_a[:3, :3] @ T_world_b[:3, :3].T).as_rotvec()
    return np.concatenate([T_world_a[:3, 3] - T_world_b[:3, 3], turn])


def moved(T_world_object: Transform, step: Vector6) -> Transform:
    """Return a pose after a small motion (m, rad): of its origin, and about it."""
    turned = Rotation.from_rotvec(step[3:]).as_matrix() @ T_world_object[:3, :3]
    return make_transform(turned, T_world_object[:3, 3] + step[:3])


def mahalanobis(step: Vector6, covariance: Matrix6) -> float:
    """Return the squared length of a motion in standard deviations."""
    return float(step @ np.linalg.solve(covariance, step))
