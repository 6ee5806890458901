"""How uncertain a pose is: what its readings leave of it, and how far what was proposed agrees with it."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.pose.choose import Candidates, Symmetries, align_to
from warehouse_sim.estimators.pose.icp.nearest import VisibleSurfaces
from warehouse_sim.estimators.pose.icp.surface import CadSurface
from warehouse_sim.geometry.pose import Transform, Transforms, invert, quat_wxyz_from_matrix, transform_points
from warehouse_sim.schema import Agreement

POINTS = 400
"""Readings of an object that are looked at."""
_PAIRS = 120
_LAGS_PX = np.array([1, 2, 4, 8, 16])
_RINGS_PX = np.array([0.5, 1.5, 3.0, 6.0, 12.0, 24.0])
"""Radii between which a lag stands for the pixels of a ring."""
_MAD_TO_SIGMA = 1.4826
_ANISOTROPY = 0.3
"""Errors across the ray over errors along it, in the middle of what ICP measures (0.1-1)."""
_GATE = 3.0
"""Readings farther from the surface than so many standard deviations are no readings of it."""
_LEAST_NOISE = 1e-4
_LEAST_GATE = 0.03


@dataclass(frozen=True, eq=False)
class Residuals:
    """Readings of one object against the surface that faces the camera; n readings."""

    lever: Float[np.ndarray, "n 3"]
    """From the object's origin to the reading, along the camera's axes (m)."""
    gradient: Float[np.ndarray, "n 3"]
    """How the scaled distance grows when the reading moves, along the camera's axes."""
    distance: Float[np.ndarray, " n"]
    """Signed, scaled so that errors of a reading are alike in all directions (m); positive in front of the surface."""
    on: Bool[np.ndarray, " n"]
    """Near enough to be of the surface."""
    noise: float
    """Robust standard deviation of the distances (m)."""
    correlated_px: float
    """Pixels that share one error, >= 1: the sum of the errors' correlation over the pixels around one."""

    @property
    def along_ray(self) -> float:
        """The noise where a surface is seen frontally, as depth (m)."""
        return self.noise / _ANISOTROPY


def measure_residuals(
    T_camera_object: Transform,
    surface: CadSurface,
    image: RgbdImage,
    mask: Bool[np.ndarray, "h w"],
    pixels: tuple[Int[np.ndarray, " n"], Int[np.ndarray, " n"]],
    rng: np.random.Generator,
) -> Residuals:
    """Compare at most ``POINTS`` readings of an object with its estimate.

    Args:
        T_camera_object: The estimate.
        surface: CAD surface of the object.
        image: Where it was seen.
        mask: Its pixels.
        pixels: Columns and rows of readings in the mask, at least one, in random order.
        rng: Chooses the neighbours that noise is compared with.
    """
    u, v = (values[:POINTS] for values in pixels)
    first, neighbour, lag = _pairs(u, v, image, mask, rng)
    columns, rows = np.concatenate([u, neighbour[0]]), np.concatenate([v, neighbour[1]])
    points = image.camera.rays_at(columns, rows) * image.depth[rows, columns][:, None].astype(float)
    T_object_camera = invert(T_camera_object)
    seen = VisibleSurfaces([surface], T_object_camera[None, :3, 3], np.array([_ANISOTROPY]))
    distance, direction = (item[0] for item in seen.nearest(transform_points(T_object_camera, points)[None]))
    noise = max(_MAD_TO_SIGMA * float(np.median(np.abs(distance[: len(u)]))), _LEAST_NOISE)
    on = np.abs(distance) <= max(_GATE * noise, _LEAST_GATE)
    return Residuals(
        points[: len(u)] - T_camera_object[:3, 3],
        direction[: len(u)] @ T_camera_object[:3, :3].T,
        distance[: len(u)],
        on[: len(u)],
        noise,
        _correlated_px(distance, on, first, len(u), lag),
    )


def _pairs(
    u: Int[np.ndarray, " n"],
    v: Int[np.ndarray, " n"],
    image: RgbdImage,
    mask: Bool[np.ndarray, "h w"],
    rng: np.random.Generator,
) -> tuple[Int[np.ndarray, " m"], tuple[Int[np.ndarray, " m"], Int[np.ndarray, " m"]], Int[np.ndarray, " m"]]:
    """Return which reading has which neighbour in the mask, along a row or a column, and how far away (px)."""
    number = np.repeat(np.arange(min(len(u), _PAIRS)), len(_LAGS_PX))
    lag = np.tile(_LAGS_PX, len(number) // len(_LAGS_PX))
    along_row = rng.random(len(number)) < 0.5
    column, row = u[number] + lag * along_row, v[number] + lag * ~along_row
    height, width = mask.shape
    inside = (column < width) & (row < height)
    column, row, number, lag = column[inside], row[inside], number[inside], lag[inside]
    there = mask[row, column] & (image.depth[row, column] > 0)
    return number[there], (column[there], row[there]), lag[there]


def _correlated_px(
    distance: Float[np.ndarray, " k"],
    on: Bool[np.ndarray, " k"],
    first: Int[np.ndarray, " m"],
    count: int,
    lag: Int[np.ndarray, " m"],
) -> float:
    """Return the sum of the correlation over the pixels around one, by rings, from pairs of readings.

    The correlation at a lag is 1 less half the mean squared difference over the variance (the variogram of Matheron,
    "Principles of geostatistics", Econ. Geol. 58, 1963).
    """
    second = count + np.arange(len(first))
    both = on[first] & on[second]
    variance = float(np.mean(distance[:count][on[:count]] ** 2)) if on[:count].any() else 0.0
    total = 1.0
    if variance <= 0.0:
        return total
    areas = np.pi * np.diff(_RINGS_PX**2)
    for step, area in zip(_LAGS_PX, areas, strict=True):
        chosen = both & (lag == step)
        if chosen.sum() < 8:
            break
        alike = 1.0 - float(np.mean((distance[first[chosen]] - distance[second[chosen]]) ** 2)) / (2.0 * variance)
        if alike < 0.05:
            break
        total += area * alike
    return total


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
    confidence = candidates.confidence.max(axis=1)
    rows = np.stack([spread, turn, moved, confidence], axis=1).tolist()
    return [Agreement(apart, angle, shift, confidence=most) for apart, angle, shift, most in rows]


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
        down: Unit vector of gravity (camera frame); None if unknown. An estimate that leans was not held
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
