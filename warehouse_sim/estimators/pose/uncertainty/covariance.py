"""How uncertain a pose is: the covariance that its readings leave, and how far what was proposed agrees with it."""

import numpy as np
from jaxtyping import Float

from warehouse_sim.estimators.pose.choose import Candidates, Symmetries, align_to
from warehouse_sim.estimators.pose.uncertainty.residuals import Residuals
from warehouse_sim.geometry.pose import Transform, Transforms, quat_wxyz_from_matrix
from warehouse_sim.schema import Agreement


def agreement(candidates: Candidates, symmetries: Symmetries, T_camera_object: Transforms) -> list[Agreement]:
    """Return what b x m proposals say of b estimates.

    Args:
        candidates: The proposals.
        symmetries: Of the objects; a proposal counts as its equivalent that is nearest to the estimate.
        T_camera_object: The estimates, (b 4 4).
    """
    quat = np.stack([quat_wxyz_from_matrix(T[:3, :3]) for T in T_camera_object])
    most = candidates.confidence.shape[1]
    joined = Candidates(
        np.concatenate([candidates.quat_wxyz, quat[:, None]], axis=1),
        np.concatenate([candidates.translation, T_camera_object[:, None, :3, 3]], axis=1),
        np.concatenate([candidates.confidence, np.zeros((len(quat), 1))], axis=1),
    )
    aligned = align_to([most] * len(quat), joined, symmetries)
    weight = candidates.confidence + 1e-9
    weight = weight / weight.sum(axis=1, keepdims=True)
    place = aligned.translation[:, :most]
    middle = (weight[..., None] * place).sum(axis=1)
    spread = np.sqrt((weight * ((place - middle[:, None]) ** 2).sum(axis=2)).sum(axis=1))
    cosine = np.clip(np.abs(np.einsum("bmi,bi->bm", aligned.quat_wxyz[:, :most], quat)), 0.0, 1.0)
    turn = np.sqrt((weight * (2.0 * np.arccos(cosine)) ** 2).sum(axis=1))
    moved = np.linalg.norm(middle - T_camera_object[:, :3, 3], axis=1)
    return [Agreement(*map(float, row)) for row in zip(spread, turn, moved, strict=True)]


Covariance = Float[np.ndarray, "6 6"]

_PRIOR_SHIFT, _PRIOR_TURN = 0.3, 0.35
"""Standard deviations (m, rad) of a pose before any reading: as far as ICP lets one move."""
_UPRIGHT = np.deg2rad(0.4)
"""How upright objects stand where gravity is known (rad)."""


def information(
    residuals: Residuals, readings: int, T_camera_object: Transform, down: Float[np.ndarray, " 3"] | None
) -> Covariance:
    """Return the information (inverse covariance) that the readings and gravity give, in the order of a covariance.

    Point-to-plane: a reading's distance changes by its gradient times the motion of the surface beneath it, its error
    has the measured noise, and of readings that share an error only as many count as there are errors.

    Args:
        residuals: Of the estimate.
        readings: How many there are of the object in the image.
        T_camera_object: The estimate.
        down: Unit vector of gravity (camera frame); None where nobody knows. An estimate that leans was not held
            upright, and gravity counts less.
    """
    jacobian = np.concatenate([residuals.gradient, np.cross(residuals.lever, residuals.gradient)], axis=1)
    weight = residuals.on / (1.0 + (residuals.distance / (3.0 * residuals.noise)) ** 2)
    matrix = (jacobian * weight[:, None]).T @ jacobian / residuals.noise**2
    matrix *= min(1.0, readings / residuals.correlated_px / max(len(weight), 1))
    matrix += np.diag([_PRIOR_SHIFT**-2] * 3 + [_PRIOR_TURN**-2] * 3)
    if down is not None:
        lean = lean_of(T_camera_object, down)
        matrix[3:, 3:] += (np.eye(3) - np.outer(down, down)) / (_UPRIGHT**2 + lean**2)
    return matrix


def lean_of(T_camera_object: Transform, down: Float[np.ndarray, " 3"]) -> float:
    """Return the angle (rad) between the object's z axis and up."""
    return float(np.arccos(np.clip(-down @ T_camera_object[:3, 2], -1.0, 1.0)))


def surface_metric(
    T_camera_object: Transform, centroid: Float[np.ndarray, " 3"], spread: Float[np.ndarray, "3 3"]
) -> Covariance:
    """Return the 6x6 matrix M with ``d M d`` the mean squared distance (m^2) that a small motion d moves the surface.

    Args:
        T_camera_object: The pose.
        centroid: Mean of the surface (object frame, m).
        spread: Covariance of the surface about its mean (object frame, m^2).
    """
    R = T_camera_object[:3, :3]
    mean = R @ centroid
    moment = R @ spread @ R.T + np.outer(mean, mean)
    # |t + r x p|^2 averaged over p = |t|^2 + 2 t . (r x mean) + r . (trace(S) - S) r.
    cross = np.array([[0.0, -mean[2], mean[1]], [mean[2], 0.0, -mean[0]], [-mean[1], mean[0], 0.0]])
    metric = np.eye(6)
    metric[:3, 3:], metric[3:, :3] = -cross, cross
    metric[3:, 3:] = np.trace(moment) * np.eye(3) - moment
    return metric


def rms_quantile(covariance: Covariance, metric: Covariance, z: float) -> float:
    """Return the RMS distance of the surface (m) that a normal motion with this covariance stays below.

    The squared distance is a weighted sum of chi-squared variables, taken for one scaled chi-squared variable with the
    same mean and variance (Satterthwaite, Biometrics Bulletin 2, 1946), whose quantile is that of Wilson and Hilferty
    (PNAS 17, 1931).

    Args:
        covariance: Of the motion.
        metric: From ``surface_metric``.
        z: Quantile of the normal distribution for the same probability: 0 for the median, 1.2816 for 90 %.
    """
    product = covariance @ metric
    mean, square = float(np.trace(product)), float(np.trace(product @ product))
    if mean <= 0.0 or square <= 0.0:
        return 0.0
    fraction = 2.0 * square / (9.0 * mean**2)  # 2 / (9 k) at k = mean^2 / square degrees of freedom
    return float(np.sqrt(mean * max(1.0 - fraction + z * np.sqrt(fraction), 0.0) ** 3))
