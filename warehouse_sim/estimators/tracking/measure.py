"""An estimate in a camera's frame as a measurement in the world."""

import numpy as np
from jaxtyping import Float

from warehouse_sim.estimators.tracking.belief import Matrix6, Measurement, Vector6, difference, mahalanobis
from warehouse_sim.estimators.tracking.settings import TrackConfig
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.schema import PoseEstimate


def in_world(estimate: PoseEstimate, T_world_camera: Transform, config: TrackConfig) -> Measurement:
    """Return the estimate as seen from the world.

    Args:
        estimate: With a covariance.
        T_world_camera: Where its camera was.
        config: How much of its error is common to all estimates of a track.
    """
    assert estimate.covariance is not None
    axes = np.zeros((6, 6))
    axes[:3, :3] = axes[3:, 3:] = T_world_camera[:3, :3]
    covariance = np.asarray(estimate.covariance, dtype=float)
    place = estimate.T_camera_object[:3, 3]
    common = np.hstack([np.sqrt(config.common_fraction) * _root(covariance), _of_camera(place, config)])
    # A direction without any uncertainty would be a measurement that no other can correct.
    own = (1.0 - config.common_fraction) * covariance + np.diag([1e-4] * 3 + [1e-4] * 3) ** 2
    return Measurement(T_world_camera @ estimate.T_camera_object, axes @ own @ axes.T, axes @ common)


def nearest_equivalent(
    T_world_object: Transform, T_world_track: Transform, covariance: Matrix6, symmetry: SymmetryGroup
) -> tuple[Transform, Vector6, float]:
    """Return which of the poses that look the same is nearest to a track, its distance, and that in deviations squared.

    Args:
        T_world_object: Any of the equivalent poses.
        T_world_track: The track's pose.
        covariance: Of the distance between them (m, rad).
        symmetry: Of the object.
    """
    steps = [(T, difference(T, T_world_track)) for T in symmetry.equivalents(T_world_object)]
    found = [(T, step, mahalanobis(step, covariance)) for T, step in steps]
    return min(found, key=lambda item: item[2])


def _root(covariance: Matrix6) -> Matrix6:
    """Return the symmetric root, so that one common error leads the same way in every image."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray((vectors * np.sqrt(np.maximum(values, 0.0))) @ vectors.T)


def _of_camera(place: Float[np.ndarray, " 3"], config: TrackConfig) -> Float[np.ndarray, "6 6"]:
    """Return what a camera's common errors do to the pose (camera axes) of something at a place (m) before it.

    Columns: an error of depth, two of where the camera is across its view, three of how it is turned.
    """
    reach = float(np.linalg.norm(place))
    effect = np.zeros((6, 6))
    effect[:3, 0] = place / reach * (config.common_depth + config.common_depth_fraction * reach)
    effect[0, 1] = effect[1, 2] = config.common_side
    turn = np.deg2rad(config.common_turn_deg)
    x, y, z = place
    effect[:3, 3:] = turn * np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    effect[3:, 3:] = turn * np.eye(3)
    return effect
