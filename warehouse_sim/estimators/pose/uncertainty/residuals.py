"""How far readings lie from the surface of an estimate, how noisy they are, and over how many pixels noise is alike."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.pose.icp.nearest import VisibleSurfaces
from warehouse_sim.estimators.pose.icp.surface import CadSurface
from warehouse_sim.geometry.pose import Transform, invert, transform_points

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
