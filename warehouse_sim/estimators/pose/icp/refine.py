"""Iterative closest point against the CAD surface: the last centimetres that a network leaves.

Point-to-plane (Chen and Medioni, 1992) on the distance field of the surface that faces the camera, in a space scaled
along the viewing direction by the ratio of the sensor's errors, with an annealed gate, Cauchy weights, and a prior at
the network's pose for the directions that the visible points do not fix. All objects of a batch step together.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.spatial.transform import Rotation

from warehouse_sim.estimators.pose.icp.nearest import VisibleSurfaces
from warehouse_sim.estimators.pose.icp.shared_errors import cells_of, shared
from warehouse_sim.estimators.pose.icp.surface import CadSurface
from warehouse_sim.geometry.pose import Transforms, invert, make_transform, rotation_angle, transform_points

_MAD_TO_SIGMA = 1.4826
"""Standard deviation of a normal variable over its median absolute deviation."""
_COARSE = 1.0 / 3.0
"""Fraction of points and surface samples that all rounds but the last use."""
_AT_ONCE = 64
"""Objects that are fitted together: what more of them need at each step no longer fits into a core's cache."""
_LEAST_POINTS = 6
_CAUCHY = 0.015
"""Where a point loses half its weight (scaled m); the noise of the points where that is more."""
_LATERAL_NOISE = 0.004
"""Error of points across the viewing direction (m); about half a pixel."""
_ANISOTROPY_START, _ANISOTROPY_MIN = 0.5, 0.1
"""Assumed ratio of the errors across and along the viewing direction in the first round, and the smallest that is
believed when it is measured."""
_UPRIGHT, _LEANING = 0.007, 0.1
"""Standard deviation of the object's own up against gravity (rad) where that is given, and the lean from which on
objects are hardly held upright (rad)."""
_STEP_TOLERANCE = 1e-4
"""An object that turns and moves by less than this (rad, m) has converged until the next round."""
_TRIMMED = 0.7
"""Fraction of the points, the nearest ones, that must fit no worse than before."""
MAX_DISPLACEMENT, MAX_TURN = 0.25, 0.35
"""A result farther from where it began than this (m, rad) is rejected."""


class IcpConfig(NamedTuple):
    """How a pose is fitted to its points."""

    rounds: int = 3
    """How often the visible surface and the noise are estimated again."""
    iterations: int = 4
    """Most steps of each round."""
    points: int = 600
    """Most points used in the last round; before, a third of them."""
    max_distance_start: float = 0.15
    """Points farther from the surface are ignored in the first step (scaled m)."""
    max_distance_end: float = 0.03
    """The same in the last step (scaled m); three times the noise of the points where that is more."""
    prior_shift: float = 0.05
    """Standard deviation of the position that a fit begins with (m)."""
    prior_turn: float = 0.05
    """Standard deviation of its rotation (rad)."""
    grazing: float = 0.0
    """Power of the cosine of incidence that weighs readings of level surfaces, where gravity is given. Time of flight
    reads them centimetres too far where it looks along them, as if the object leant: 2 trusts gravity instead, and
    objects that truly lean by less than some 5 degrees are taken for upright. 0 believes all readings alike."""


@dataclass(frozen=True, eq=False)
class Cloud:
    """The points of b objects, n rows each, of which the first ones hold a point and the others are filled up."""

    points: Float[np.ndarray, "b n 3"]
    """Camera frame (m)."""
    present: Bool[np.ndarray, "b n"]

    @classmethod
    def of(cls, clouds: Sequence[Float[np.ndarray, "p 3"]], most: int) -> "Cloud":
        """Stack clouds in random order, each cut to ``most`` points; an empty one is not allowed."""
        counts = np.minimum([len(cloud) for cloud in clouds], most)
        points = np.empty((len(clouds), int(counts.max()), 3))
        for row, cloud, count in zip(points, clouds, counts, strict=True):
            row[:count], row[count:] = cloud[:count], cloud[0]
        return cls(points, np.arange(points.shape[1]) < counts[:, None])

    @cached_property
    def cells(self) -> Int[np.ndarray, "b n"]:
        """Return the cell of the image of each point, see ``shared_errors``."""
        return cells_of(self.points, self.present)

    def first(self, count: int) -> "Cloud":
        """Return the first rows of each object."""
        return Cloud(self.points[:, :count], self.present[:, :count])

    def in_object_frame(self, T_camera_object: Transforms) -> Float[np.ndarray, "b n 3"]:
        """Return the points in the object frames (m)."""
        return transform_points(invert(T_camera_object), self.points)

    def median(self, values: Float[np.ndarray, "b n"]) -> Float[np.ndarray, " b"]:
        """Return the median over the points of each object."""
        ordered = np.sort(np.where(self.present, values, np.inf), axis=1)
        return ordered[np.arange(len(values)), (self.present.sum(axis=1) - 1) // 2]


class Surfaces(Protocol):
    """The surfaces of b objects that points are drawn to."""

    def nearest(
        self, points: Float[np.ndarray, "b n 3"], /
    ) -> tuple[Float[np.ndarray, "b n"], Float[np.ndarray, "b n 3"]]:
        """Return the signed distance (m) of points in the object frames, and its gradient there."""


@dataclass(frozen=True, eq=False)
class Fit:
    """How well points lie on the surfaces, as mean scaled distances (m) of each object."""

    truncated: Float[np.ndarray, " b"]
    """Over all points, each distance at most the gate."""
    trimmed: Float[np.ndarray, " b"]
    """Over the nearest 70 % of the points."""

    def improves_on(self, other: "Fit") -> Bool[np.ndarray, " b"]:
        """Return which objects fit better by all points and no worse by the nearest ones."""
        return (self.truncated < other.truncated) & (self.trimmed <= other.trimmed)


def refine_poses(
    T_camera_object: Transforms,
    clouds: Sequence[Float[np.ndarray, "p 3"]],
    surfaces: Sequence[CadSurface],
    config: IcpConfig,
    up: Float[np.ndarray, "#b 3"] | Float[np.ndarray, " 3"] | None = None,
) -> Transforms:
    """Return for each of b objects the pose that fits its points, or the given one where the fit gets no better.

    Args:
        T_camera_object: Poses to start from, (b 4 4).
        clouds: What the camera sees of each object (camera frame, m), in random order.
        surfaces: CAD surface of each object.
        config: Settings.
        up: Unit vector against gravity (camera frame) that the objects' z axes are held to softly, one for all or one
            each, NaN if unknown; None leaves it.
    """
    if not clouds:
        return T_camera_object
    T, anisotropy = fit_poses(T_camera_object, clouds, surfaces, config, up)
    whole = Cloud.of(clouds, config.points)
    fits = [measure_fit(pose, whole, surfaces, anisotropy, config.max_distance_start) for pose in (T, T_camera_object)]
    better = fits[0].improves_on(fits[1])
    return np.where(better[:, None, None], T, T_camera_object)


def fit_poses(
    T_camera_object: Transforms,
    clouds: Sequence[Float[np.ndarray, "p 3"]],
    surfaces: Sequence[CadSurface],
    config: IcpConfig,
    up: Float[np.ndarray, "#b 3"] | Float[np.ndarray, " 3"] | None = None,
) -> tuple[Transforms, Float[np.ndarray, " b"]]:
    """Return the poses after all steps, whether they fit better or not, and the ratios of errors that were measured.

    A result that is too far from where it began is the given pose. Arguments are those of ``refine_poses``, of at least
    one object.
    """
    ups = None if up is None else np.broadcast_to(up, (len(clouds), 3))
    parts = [slice(start, start + _AT_ONCE) for start in range(0, len(clouds), _AT_ONCE)]
    fits = [
        _fit_some(T_camera_object[part], clouds[part], surfaces[part], config, None if ups is None else ups[part])
        for part in parts
    ]
    return np.concatenate([T for T, _ in fits]), np.concatenate([anisotropy for _, anisotropy in fits])


def _fit_some(
    T_camera_object: Transforms,
    clouds: Sequence[Float[np.ndarray, "p 3"]],
    surfaces: Sequence[CadSurface],
    config: IcpConfig,
    up: Float[np.ndarray, "b 3"] | None,
) -> tuple[Transforms, Float[np.ndarray, " b"]]:
    whole = Cloud.of(clouds, config.points)
    coarse = whole.first(max(int(config.points * _COARSE), _LEAST_POINTS))
    T, delta = T_camera_object, np.zeros((len(clouds), 6))
    anisotropy = np.full(len(clouds), _ANISOTROPY_START)
    alike = np.ones(len(clouds))
    seen: VisibleSurfaces | None = None
    for round_index in range(config.rounds):
        last = round_index == config.rounds - 1
        cloud = whole if last else coarse
        if seen is not None:
            anisotropy = _measure_anisotropy(cloud, T, seen, anisotropy)
        seen = VisibleSurfaces(surfaces, invert(T)[:, :3, 3], anisotropy, 1.0 if last else _COARSE)
        if last and round_index and up is not None:
            alike = _readings_alike(cloud, T, seen, config)
        T, delta = fit_to_surfaces(T, delta, cloud, seen, round_index, config, up, alike)
    shift = np.linalg.norm(T[:, :3, 3] - T_camera_object[:, :3, 3], axis=1)
    turn = rotation_angle(T[:, :3, :3], T_camera_object[:, :3, :3])
    near = (shift <= MAX_DISPLACEMENT) & (turn <= MAX_TURN)
    return np.where(near[:, None, None], T, T_camera_object), anisotropy


def fit_to_surfaces(
    T_camera_object: Transforms,
    delta: Float[np.ndarray, "b 6"],
    cloud: Cloud,
    seen: Surfaces,
    round_index: int,
    config: IcpConfig,
    up: Float[np.ndarray, "#b 3"] | Float[np.ndarray, " 3"] | None,
    alike: Float[np.ndarray, " b"] | float = 1.0,
) -> tuple[Transforms, Float[np.ndarray, "b 6"]]:
    """Return the poses, and the sum of the motions so far, after the steps of one round; converged objects stay.

    Args:
        T_camera_object: Poses to start from, (b 4 4).
        delta: Sum of the motions before (rotation vector, shift), from the pose that the prior is about.
        cloud: What the camera sees of each object.
        seen: What the points are drawn to.
        round_index: Number of the round, which says how narrow the gate is.
        config: Settings.
        up: Against gravity (camera frame); None if unknown.
        alike: How many readings of each object count as one against gravity.
    """
    T, moving = T_camera_object, np.ones((len(delta), 1), dtype=bool)
    for iteration in range(config.iterations):
        gate = _gate(config, round_index * config.iterations + iteration)
        change = np.where(moving, _gauss_newton(cloud, T, seen, delta, gate, config, up, alike), 0.0)
        delta = delta + change
        # The step moves the points in the object frame; the object moves the other way.
        T = T @ invert(make_transform(Rotation.from_rotvec(change[:, :3]).as_matrix(), change[:, 3:]))
        moving &= np.abs(change).max(axis=1, keepdims=True) >= _STEP_TOLERANCE
        if not moving.any():
            break
    return T, delta


def measure_fit(
    T_camera_object: Transforms,
    cloud: Cloud,
    surfaces: Sequence[CadSurface],
    anisotropy: Float[np.ndarray, " b"],
    gate: float,
) -> Fit:
    """Return how well the points fit the surfaces that face the camera.

    Args:
        T_camera_object: Poses to judge, (b 4 4).
        cloud: What the camera sees of each object.
        surfaces: CAD surface of each object.
        anisotropy: Noise across the viewing direction over noise along it, 0-1, of each object.
        gate: Distance from which points count the same (m).
    """
    seen = VisibleSurfaces(surfaces, invert(T_camera_object)[:, :3, 3], anisotropy)
    distance = np.abs(seen.nearest(cloud.in_object_frame(T_camera_object))[0])
    count = cloud.present.sum(axis=1)
    truncated = np.where(cloud.present, np.minimum(distance, gate), 0.0).sum(axis=1) / count
    ordered = np.sort(np.where(cloud.present, distance, np.inf), axis=1)
    kept = np.arange(ordered.shape[1]) < np.ceil(_TRIMMED * count)[:, None]
    return Fit(truncated, np.where(kept, ordered, 0.0).sum(axis=1) / kept.sum(axis=1))


def _measure_anisotropy(
    cloud: Cloud,
    T_camera_object: Transforms,
    seen: VisibleSurfaces,
    anisotropy: Float[np.ndarray, " b"],
) -> Float[np.ndarray, " b"]:
    distance, _ = seen.nearest(cloud.in_object_frame(T_camera_object))
    # Most of the surface is seen frontally, where a scaled distance is one along the ray times the anisotropy.
    along_ray = _MAD_TO_SIGMA * cloud.median(np.abs(distance)) / anisotropy
    return np.clip(_LATERAL_NOISE / np.maximum(along_ray, 1e-6), _ANISOTROPY_MIN, 1.0)


def _gate(config: IcpConfig, step: int) -> float:
    fraction = step / max(1, config.rounds * config.iterations - 1)
    return config.max_distance_start * (config.max_distance_end / config.max_distance_start) ** fraction


def _gauss_newton(
    cloud: Cloud,
    T_camera_object: Transforms,
    seen: Surfaces,
    delta: Float[np.ndarray, "b 6"],
    gate: float,
    config: IcpConfig,
    up: Float[np.ndarray, "#b 3"] | Float[np.ndarray, " 3"] | None,
    alike: Float[np.ndarray, " b"] | float,
) -> Float[np.ndarray, "b 6"]:
    """Return the small motions (rotation vector, shift) of the points that bring them closer to the surfaces.

    Args:
        cloud: What the camera sees of each object.
        T_camera_object: Current poses.
        seen: The sides of the CAD surfaces that face the camera.
        delta: Sum of the motions so far, which the prior pulls back to zero.
        gate: Largest distance that counts (scaled m).
        config: Settings.
        up: Against gravity (camera frame); None if unknown.
        alike: How many readings of each object count as one against gravity.
    """
    distance, jacobian, near, noise = _residuals(cloud, T_camera_object, seen, gate)
    weight = near / (1.0 + (distance / np.maximum(_CAUCHY, noise)) ** 2)
    if up is not None and config.grazing:
        trust = _level_trust(cloud, T_camera_object, jacobian, config)
        weight = np.where(np.isfinite(up[..., :1]), trust, 1.0) * weight
    weighted = np.swapaxes(jacobian * weight[..., None], 1, 2)
    precision = noise**2 / np.array([config.prior_turn] * 3 + [config.prior_shift] * 3) ** 2
    matrix = weighted @ jacobian + precision[:, :, None] * np.eye(6)
    right = -(weighted @ distance[..., None])[..., 0] - precision * delta
    if up is not None:
        # How far the object's z axis is from up, along its own x and y.
        lean = np.einsum("bi,bij->bj", np.broadcast_to(up, (len(delta), 3)), T_camera_object[:, :3, :2])
        known = np.isfinite(lean[:, 0])
        lean, weight_of_up = np.where(known[:, None], lean, 0.0), known * (noise[:, 0] / _UPRIGHT) ** 2
        # Gravity weighs as much against all readings as against so many as have errors of their own, and little
        # where an object leans beyond uncertainty (Geman and McClure, 1987).
        weight_of_up *= alike / (1.0 + (lean**2).sum(axis=1) / _LEANING**2) ** 2
        matrix[:, 0, 0] += weight_of_up
        matrix[:, 1, 1] += weight_of_up
        # The points turn by (a, b, .): up in the object frame, (lean, 1), moves by (b, -a, 0), and shall be (0, 0, 1).
        right[:, 0] += weight_of_up * lean[:, 1]
        right[:, 1] -= weight_of_up * lean[:, 0]
    return np.linalg.solve(matrix, right[..., None])[..., 0]


def _residuals(
    cloud: Cloud, T_camera_object: Transforms, seen: Surfaces, gate: float
) -> tuple[Float[np.ndarray, "b n"], Float[np.ndarray, "b n 6"], Bool[np.ndarray, "b n"], Float[np.ndarray, "b 1"]]:
    """Return scaled distances (m), how they grow with a motion of the points, which are near enough, and the noise."""
    points = cloud.in_object_frame(T_camera_object)
    distance, direction = seen.nearest(points)
    noise = np.maximum(_MAD_TO_SIGMA * cloud.median(np.abs(distance)), 1e-3)[:, None]
    near = cloud.present & (np.abs(distance) <= np.maximum(gate, 3.0 * noise))
    return distance, np.concatenate([np.cross(points, direction), direction], axis=2), near, noise


def _readings_alike(
    cloud: Cloud, T_camera_object: Transforms, seen: VisibleSurfaces, config: IcpConfig
) -> Float[np.ndarray, " b"]:
    """Return how many readings of each object share one error, as far as no motion takes it away."""
    distance, jacobian, near, noise = _residuals(cloud, T_camera_object, seen, config.max_distance_end)
    weight = near / (1.0 + (distance / noise) ** 2)
    if config.grazing:
        weight = weight * _level_trust(cloud, T_camera_object, jacobian, config)
    weighted = np.swapaxes(jacobian * weight[..., None], 1, 2)
    step = np.linalg.solve(weighted @ jacobian + 1e-6 * np.eye(6), -(weighted @ distance[..., None]))
    return shared(distance + (jacobian @ step)[..., 0], near, cloud.cells)


def _level_trust(
    cloud: Cloud, T_camera_object: Transforms, jacobian: Float[np.ndarray, "b n 6"], config: IcpConfig
) -> Float[np.ndarray, "b n"]:
    """Return how far each reading is believed, 0-1: all of upright surfaces, less of level ones seen from the side."""
    towards = jacobian[..., 3:]  # along the normal of the surface
    rays = cloud.in_object_frame(T_camera_object) - invert(T_camera_object)[:, None, :3, 3]
    normal = np.maximum(np.linalg.norm(towards, axis=2), 1e-9)
    cosine = np.abs((rays * towards).sum(axis=2)) / (normal * np.linalg.norm(rays, axis=2))
    level = (towards[..., 2] / normal) ** 2
    trust: Float[np.ndarray, "b n"] = np.clip(cosine, 1e-3, 1.0) ** (config.grazing * level)
    return trust
