"""Where down is, out of all that stands upright or lies level in sight.

Floors, decks and tops of loads lie level; fronts of loads, walls, beams and uprights stand. Their planes are found one
after another, and each makes those directions of gravity likely to which it would be level or upright. A camera on a
truck is taken to look about level before anything is seen. The sum over a grid of directions gives the most likely one
and how sure it is.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.estimators.gravity import Direction
from warehouse_sim.estimators.image import RgbdImage

_GRAVITY = np.deg2rad(0.5)
"""Standard deviation of gravity that is given, and of a pallet's own tilt (rad)."""
_POINTS, _PLANES, _TRIES = 2500, 8, 150
_REACH = 0.35
"""Points (m) that span a plane lie within so much of one another along each axis."""
_THICK = (0.010, 0.020)
"""Half the thickness of a plane (m), and how much it grows with each metre of distance."""
_LEAST_FRACTION = 0.015
"""Of the readings that a plane must have."""
_STEP = np.deg2rad(0.5)
_ROLLS = np.arange(-np.deg2rad(8.0), np.deg2rad(8.0) + 1e-9, _STEP)
_PITCHES = np.arange(-np.deg2rad(30.0), np.deg2rad(30.0) + 1e-9, _STEP)
_LEVEL = np.deg2rad((3.0, 4.0))
"""Standard deviations of a camera's roll and pitch on a truck (rad)."""
_LOOKING_DOWN = (0.2, np.deg2rad(15.0))
"""Chance that it is tilted on purpose, and the standard deviation of its pitch then."""
_LEAST_SIGMA, _STRAIGHT = 0.003, 0.08
"""Least error of readings across a plane (m), and over what length (m) errors are alike: depth cameras bend planes, and
what is longer averages it out."""
_LEAN, _SLOPE = np.deg2rad(1.0), np.deg2rad(0.5)
"""How far loads and uprights lean, and floors slope (rad, standard deviations)."""
_LYING, _NEITHER = 0.4, 0.3
"""Chance that a plane lies level, and the density (a rad) of directions for one that neither lies nor stands."""


@dataclass(frozen=True, eq=False)
class Leveling:
    """Gravity in the camera frame."""

    down: Direction
    roll: float
    """Standard deviation about the viewing direction (rad)."""
    pitch: float
    """The same about the image's rows (rad)."""


@dataclass(frozen=True, eq=False)
class _Plane:
    normal: Float[np.ndarray, " 3"]
    axes: Float[np.ndarray, "2 3"]
    """Its principal directions."""
    extent: Float[np.ndarray, " 2"]
    """Standard deviation of its points along them (m)."""
    sigma: float
    """Error of its readings (m)."""


def find_down(image: RgbdImage, rng: np.random.Generator) -> Leveling:
    """Return gravity as the image brings it, else as the planes in sight have it."""
    if image.gravity is not None:
        return Leveling(np.asarray(image.gravity, dtype=float), _GRAVITY, _GRAVITY)
    v, u = np.nonzero(image.depth > 0)
    if len(u) == 0:
        return Leveling(np.array([0.0, 1.0, 0.0]), *_LEVEL)
    chosen = rng.choice(len(u), min(len(u), _POINTS), replace=False)
    v, u = v[chosen], u[chosen]
    points = image.camera.rays_at(u, v) * image.depth[v, u][:, None].astype(float)
    return _most_likely(_planes(points, rng))


def _most_likely(planes: list[_Plane]) -> Leveling:
    """Return the likeliest direction of a grid, and how sure it is among its neighbours."""
    roll, pitch = np.meshgrid(_ROLLS, _PITCHES, indexing="ij")
    down = np.stack([np.tan(roll), np.ones_like(roll), np.tan(pitch)], axis=-1)
    down /= np.linalg.norm(down, axis=-1, keepdims=True)
    part, wide = _LOOKING_DOWN
    log = -0.5 * (roll / _LEVEL[0]) ** 2
    log += np.log((1.0 - part) * _bell(pitch, _LEVEL[1]) + part * _bell(pitch, wide))
    for plane in planes:
        log += np.log(_density(plane, down))
    best = np.unravel_index(int(log.argmax()), log.shape)
    near = (np.abs(roll - roll[best]) < 6.5 * _STEP) & (np.abs(pitch - pitch[best]) < 6.5 * _STEP)
    weight = np.where(near, np.exp(log - log[best]), 0.0)
    weight /= weight.sum()
    mean = np.einsum("rp,rpi->i", weight, down)
    deviation = [
        np.sqrt((weight * (axis - (weight * axis).sum()) ** 2).sum() + _STEP**2 / 12.0) for axis in (roll, pitch)
    ]
    return Leveling(mean / np.linalg.norm(mean), *map(float, deviation))


def _density(plane: _Plane, down: Float[np.ndarray, "r p 3"]) -> Float[np.ndarray, "r p"]:
    """Return how likely a plane is seen as it is, were gravity each of the directions (a rad, up to a constant)."""
    along = np.clip(down @ plane.normal, -1.0, 1.0)
    # What turns the normal towards a direction is the error across the plane along the tangent in that direction.
    tangent = down - along[..., None] * plane.normal
    tangent /= np.maximum(np.linalg.norm(tangent, axis=-1, keepdims=True), 1e-9)
    error = plane.sigma / np.maximum(plane.extent, 0.02) / np.sqrt(np.maximum(plane.extent / _STRAIGHT, 1.0))
    variance = (tangent @ plane.axes.T) ** 2 @ error**2
    standing, lying = np.sqrt(variance + _LEAN**2), np.sqrt(variance + _SLOPE**2)
    upright = np.exp(-0.5 * (np.arcsin(along) / standing) ** 2) / standing
    level = np.exp(-0.5 * (np.arccos(np.abs(along)) / lying) ** 2) / (3.0 * lying**2)
    return np.asarray((1.0 - _LYING) * upright + _LYING * level + _NEITHER)


def _bell(value: Float[np.ndarray, "r p"], deviation: float) -> Float[np.ndarray, "r p"]:
    return np.asarray(np.exp(-0.5 * (value / deviation) ** 2) / deviation)


def _planes(points: Float[np.ndarray, "n 3"], rng: np.random.Generator) -> list[_Plane]:
    """Return planes by RANSAC (Fischler and Bolles 1981), each without the points near those before it."""
    found: list[_Plane] = []
    left, least = points, max(60.0, _LEAST_FRACTION * len(points))
    while len(found) < _PLANES and len(left) >= least:
        tolerance = _THICK[0] + _THICK[1] * left[:, 2]
        on = _best_plane(left, tolerance, rng)
        if on.sum() < least:
            break
        middle, axes, lengths, sigma = _fitted(left, on, tolerance)
        found.append(_Plane(axes[2], axes[:2], lengths, sigma))
        # Slices of what is left beside a noisy plane would lean to either side.
        left = left[np.abs((left - middle) @ axes[2]) > 2.0 * tolerance]
    return found


def _fitted(
    points: Float[np.ndarray, "n 3"], on: Bool[np.ndarray, " n"], tolerance: Float[np.ndarray, " n"]
) -> tuple[Float[np.ndarray, " 3"], Float[np.ndarray, "3 3"], Float[np.ndarray, " 2"], float]:
    """Return middle, axes with the normal last, extent and error of the plane through most points of another."""
    for _ in range(5):
        middle = points[on].mean(axis=0)
        axes = np.linalg.svd(points[on] - middle, full_matrices=False)[2]
        away = np.abs((points - middle) @ axes[2])
        sigma = max(1.4826 * float(np.median(away[on])), _LEAST_SIGMA)
        again = away <= np.minimum(tolerance, 2.5 * sigma)
        on = again if again.sum() >= 20 else on
    return middle, axes, ((points[on] - middle) @ axes[:2].T).std(axis=0), sigma


def _best_plane(
    points: Float[np.ndarray, "n 3"], tolerance: Float[np.ndarray, " n"], rng: np.random.Generator
) -> Bool[np.ndarray, " n"]:
    """Return which points lie on that plane through three neighbours on which most of them lie."""
    first = points[rng.integers(len(points), size=_TRIES)]
    near = (np.abs(points[None] - first[:, None]) < _REACH).all(axis=2)
    second, third = np.argpartition(-(near * rng.random(near.shape)), 2, axis=1)[:, 1:3].T
    normals = np.cross(points[second] - first, points[third] - first)
    lengths = np.linalg.norm(normals, axis=1)
    normals = normals / np.maximum(lengths, 1e-9)[:, None]
    on = np.abs(points @ normals.T - (normals * first).sum(axis=1)) <= tolerance[:, None]
    counts = np.where(lengths > 1e-3, on.sum(axis=0), 0)
    return np.asarray(on[:, counts.argmax()])
