"""Upright planes that may hold a pallet's face, what a depth image shows there, and the plane of a face's material.

Readings are carried to a grid in the plane. There each one is on the plane, behind it (the camera looks through an
opening, or past the object), before it (something covers it), or missing.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.ndimage import binary_erosion

from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.pose.faces.shape import FOOT, HEIGHT, MIDDLE, WIDTH, pocket_borders
from warehouse_sim.geometry.pose import Transform, invert, make_transform, rotation_y, rotation_z, transform_points

_MOST_ODDS = 3.0
"""Log odds that one reading can give: one in twenty lies (rims, several paths)."""
_ON_PLANE = {"material": 0.95, "opening": 0.05, "other": 0.25}
"""Part of the readings that lie on the plane of a face: what is something else may be a load that is flush with it, a
beam, or a neighbour."""
_DEEP = 1.0
"""Readings behind a plane are spread over so much (m)."""
_MISSING, _BEFORE = -0.4, -0.5
"""Log odds of a place without a reading, and of one that something covers: mostly nothing is there to be read in an
opening, and seldom does something stand before a face that is to be entered."""


@dataclass(frozen=True, eq=False)
class PlaneView:
    """A grid in a plane, row 0 lowest, column 0 rightmost, with what was read in each of its cells."""

    T_camera_plane: Transform
    """x inwards, y to the left, z up."""
    low: Float[np.ndarray, " 2"]
    """y and z of the outer corner of the first cell (m)."""
    cell: float
    """Edge length of a cell (m)."""
    behind: Float[np.ndarray, "r c"]
    """How far behind the plane the reading is (m); nan where there is none."""
    claimed: Bool[np.ndarray, "r c"]
    """Whether the detection's mask holds the place."""
    beyond: Bool[np.ndarray, "r c"]
    """Whether it lies outside the image."""
    pixel: Int[np.ndarray, "r c"]
    """Which pixel was read, row-major."""
    pixels_a_cell: float
    """Pixels that a cell has, in the middle of the plane."""

    def coordinates(self) -> tuple[Float[np.ndarray, " c"], Float[np.ndarray, " r"]]:
        """Return y of the columns' centres and z of the rows' (m)."""
        rows, columns = self.behind.shape
        return self.low[0] + self.cell * (np.arange(columns) + 0.5), self.low[1] + self.cell * (np.arange(rows) + 0.5)

    def log_odds(self, sigma: float) -> tuple[Float[np.ndarray, "r c"], Float[np.ndarray, "r c"]]:
        """Return ln p(reading | the face's material) / p(reading | something else), and the same of openings."""
        off = np.nan_to_num(self.behind)
        near = np.exp(-0.5 * (off / sigma) ** 2) / (sigma * np.sqrt(2.0 * np.pi))
        chance = {kind: part * near + (1.0 - part) / _DEEP for kind, part in _ON_PLANE.items()}
        covered, missing = off < -3.0 * sigma, np.isnan(self.behind)
        found = []
        for kind, lost in (("material", _MISSING), ("opening", 0.0)):
            odds = np.clip(np.log(chance[kind] / chance["other"]), -_MOST_ODDS, _MOST_ODDS)
            odds = np.where(covered, _BEFORE, odds)
            odds = np.where(missing, lost, odds)
            found.append(np.where(self.beyond, 0.0, odds))
        return found[0], found[1]

    def claim(self, inside: float, other: float) -> Float[np.ndarray, "r c"]:
        """Return ln p(what the mask says of a place | it is of a kind) / p(the same | it is something else).

        Args:
            inside: Part of the kind's places that masks hold.
            other: The same of all that is something else.
        """
        odds = np.where(self.claimed, np.log(inside / other), np.log((1.0 - inside) / (1.0 - other)))
        return np.where(self.beyond, 0.0, odds)


def view_plane(
    image: RgbdImage,
    mask: Bool[np.ndarray, "h w"],
    T_camera_plane: Transform,
    low: Float[np.ndarray, " 2"],
    high: Float[np.ndarray, " 2"],
    cell: float,
) -> PlaneView:
    """Return what is read in a rectangle of a plane.

    Args:
        image: The depth image.
        mask: Pixels of the detection.
        T_camera_plane: The plane's frame, x inwards.
        low: Least y and z of the rectangle (m).
        high: Greatest ones.
        cell: Edge length of a cell (m).
    """
    columns, rows = np.maximum(np.ceil((high - low) / cell), 1).astype(int)
    y, z = low[0] + cell * (np.arange(columns) + 0.5), low[1] + cell * (np.arange(rows) + 0.5)
    places = np.stack([np.zeros((rows, columns)), *np.meshgrid(y, z)], axis=-1).reshape(-1, 3)
    seen = transform_points(T_camera_plane, places)
    ahead = seen[:, 2] > 0.05
    uv = np.rint(image.camera.project(np.where(ahead[:, None], seen, [0.0, 0.0, 1.0])))
    height, width = image.depth.shape
    inside = ahead & (uv >= 0).all(axis=1) & (uv[:, 0] < width) & (uv[:, 1] < height)
    u, v = np.where(inside[:, None], uv, 0).astype(np.int64).T
    depth = np.where(inside, image.depth[v, u], 0.0).astype(float)
    # Along the ray of the place itself, not of the pixel's centre: on a slanted plane half a pixel is centimetres.
    read = seen * (depth / np.where(ahead, seen[:, 2], 1.0))[:, None]
    behind = np.where(depth > 0, transform_points(invert(T_camera_plane), read)[:, 0], np.nan)
    shape = rows, columns
    return PlaneView(
        T_camera_plane,
        np.asarray(low, dtype=float),
        cell,
        behind.reshape(shape),
        (mask[v, u] & inside).reshape(shape),
        ~inside.reshape(shape),
        np.where(inside, v * width + u, -1).reshape(shape),
        _pixels_a_cell(image, T_camera_plane, cell),
    )


def _pixels_a_cell(image: RgbdImage, T_camera_plane: Transform, cell: float) -> float:
    """Return the area (px) that a cell at the plane's origin covers in the image."""
    corners = np.array([[0.0, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]])
    origin, left, up = image.camera.project(transform_points(T_camera_plane, corners))
    (a, b), (c, d) = left - origin, up - origin
    return float(abs(a * d - b * c)) * (cell / 0.1) ** 2


_PAIRS = 400
"""Lines that are tried; with two points of one face in ten pairs, all but 1e-18 of the clouds get a good one."""
_LEAST_APART = 0.15
"""Points (m) that span a line."""
_LEAST_FACING = 0.2
"""Cosine between a face's normal and the ray to it: flatter than 78 degrees nothing is seen in pockets."""
_ALIKE = (0.17, 0.08)
"""Lines within such an angle (rad) and distance (m) are the same."""
_PRICE_BEFORE = 0.5
"""Price of a point before the line, where nothing of the pallet can be, against the gain of one on it."""


def face_planes(
    points: Float[np.ndarray, "n 3"], tolerance: float, most: int, rng: np.random.Generator
) -> list[Transform]:
    """Return frames ``T_upright_plane`` of upright planes that face the sensor, x inwards, best first.

    Args:
        points: In a frame with z up and the sensor at its origin (m).
        tolerance: Half the thickness of a plane (m).
        most: How many planes.
        rng: Source of randomness.
    """
    first, second = rng.integers(len(points), size=(2, _PAIRS))
    along = points[second, :2] - points[first, :2]
    length = np.linalg.norm(along, axis=1)
    apart = length >= _LEAST_APART
    along, start = along[apart] / length[apart, None], points[first[apart], :2]
    inwards = np.stack([-along[:, 1], along[:, 0]], axis=1)
    distance = (inwards * start).sum(axis=1)
    inwards, distance = inwards * np.sign(distance)[:, None], np.abs(distance)
    facing = distance / np.maximum(np.linalg.norm(start, axis=1), 1e-9) >= _LEAST_FACING
    inwards, distance = inwards[facing], distance[facing]
    behind = points[:, :2] @ inwards.T - distance
    score = (np.abs(behind) <= tolerance).sum(axis=0) - _PRICE_BEFORE * (behind < -tolerance).sum(axis=0)
    found: list[Transform] = []
    for index in np.argsort(-score):
        T = _placed(points, inwards[index], distance[index], tolerance)
        if not any(_is_alike(T, other) for other in found):
            found.append(T)
        if len(found) == most:
            break
    return found


def _placed(
    points: Float[np.ndarray, "n 3"], inwards: Float[np.ndarray, " 2"], distance: float, tolerance: float
) -> Transform:
    """Return the frame at the middle of the points that are on the plane, after a robust fit of its line."""
    for _ in range(4):
        along = np.array([-inwards[1], inwards[0]])
        behind, aside = points[:, :2] @ inwards - distance, points[:, :2] @ along
        weight = (np.abs(behind) <= 2.0 * tolerance) / (1.0 + (behind / tolerance * 2.0) ** 2)
        mean = (weight * aside).sum() / weight.sum()
        centred = aside - mean
        slope = (weight * centred * behind).sum() / max((weight * centred**2).sum(), 1e-9)
        offset = (weight * behind).sum() / weight.sum()
        place = inwards * (distance + offset) + along * mean
        inwards = inwards - slope * along
        inwards /= np.linalg.norm(inwards)
        distance = float(inwards @ place)
    on = np.abs(points[:, :2] @ inwards - distance) <= tolerance
    height = float(np.median(points[on, 2])) if on.any() else 0.0
    return make_transform(rotation_z(float(np.arctan2(inwards[1], inwards[0]))), np.array([*place, height]))


def _is_alike(T: Transform, other: Transform) -> bool:
    cosine = float(T[:2, 0] @ other[:2, 0])
    away = abs(float(other[:2, 0] @ (T[:2, 3] - other[:2, 3])))
    return cosine >= np.cos(_ALIKE[0]) and away <= _ALIKE[1]


_MAD_TO_SIGMA = 1.4826
_LEAST_CELLS = 40
_FARTHEST_LAG = 12
_BENT, _STRAIGHT = 0.005, 0.08
"""By how much depth cameras bend a plane (m) over such a length (m); what is longer averages it out."""
_LEAST_CORRELATION = 0.1


@dataclass(frozen=True, eq=False)
class SolidPlane:
    """A plane through the material."""

    T_camera_plane: Transform
    covariance: Float[np.ndarray, "3 3"]
    """Of its turn about z (rad), its turn about y (rad) and its place along x (m), in its own frame."""
    sigma: float
    """Error of a reading across it (m)."""
    dependent: float
    """How many neighbouring pixels are worth one independent reading."""


def fit_plane(view: PlaneView, shape: Float[np.ndarray, " 8"], sigma: float, tilt: tuple[float, float]) -> SolidPlane:
    """Return the plane through what is seen of a face's material.

    Args:
        view: What is seen.
        shape: The face.
        sigma: Error of readings (m) as it is known so far.
        tilt: Turn about y (rad) that gravity requires, from the view's own plane, and its standard deviation.
    """
    material = _material(view, shape) & (np.abs(np.nan_to_num(view.behind, nan=np.inf)) <= 4.0 * sigma)
    y, z = (axis[material] for axis in np.meshgrid(*view.coordinates()))
    behind = view.behind[material]
    prior = np.diag([1e-6, 1.0 / tilt[1] ** 2, 1e-6])
    if len(behind) < _LEAST_CELLS:
        return SolidPlane(view.T_camera_plane, np.linalg.inv(prior + np.diag([25.0, 0.0, 400.0])), sigma, 9.0)
    # Columns: turn left about z, turn down about y, shift along x; a place of the plane moves by these along x.
    jacobian = np.stack([-y, z, np.ones_like(y)], axis=1)
    # Readings bend a plane more than their noise says, and the more so the shorter it is.
    extent = np.maximum([y.std(), z.std()], 0.01)
    bent = np.diag([*_BENT / extent / np.sqrt(np.maximum(extent / _STRAIGHT, 1.0)), 0.0]) ** 2
    found, scale, dependent = np.zeros(3), sigma, 9.0
    for _ in range(6):
        away = behind - jacobian @ found
        scale = max(_MAD_TO_SIGMA * float(np.median(np.abs(away))), 5e-4)
        weight = 1.0 / (1.0 + (away / (2.4 * scale)) ** 2)
        dependent = max(_dependent_cells(view, material, away) * view.pixels_a_cell, 1.0)
        weighted = jacobian * (weight * view.pixels_a_cell / (dependent * scale**2))[:, None]
        own = np.linalg.inv(weighted.T @ jacobian)
        information = np.linalg.inv(own + bent)
        matrix = information + prior
        found = np.linalg.solve(matrix, information @ own @ weighted.T @ behind + prior @ np.array([0.0, tilt[0], 0.0]))
    turned = make_transform(rotation_z(found[0]) @ rotation_y(found[1]), np.array([found[2], 0.0, 0.0]))
    return SolidPlane(view.T_camera_plane @ turned, np.linalg.inv(matrix), scale, dependent)


def _material(view: PlaneView, shape: Float[np.ndarray, " 8"]) -> Bool[np.ndarray, "r c"]:
    """Return the cells of a face's material, a cell and a half pixel away from all edges."""
    y, z = np.meshgrid(*view.coordinates())
    q = shape[None]
    inside = np.abs(y - q[0, MIDDLE]) <= q[0, WIDTH] / 2.0
    inside &= (z >= q[0, FOOT]) & (z <= q[0, FOOT] + q[0, HEIGHT])
    for right, left, bottom, top in pocket_borders(q):
        inside &= ~((y >= right) & (y <= left) & (z >= bottom) & (z <= top))
    away = 1 + round(0.5 / max(view.pixels_a_cell, 0.04) ** 0.5)
    inner = binary_erosion(inside, np.ones((2 * away + 1, 2 * away + 1), bool))
    # Far away a face is a few pixels high, and nothing is left of it.
    return (inner if inner.sum() >= _LEAST_CELLS else inside) & ~np.isnan(view.behind)


def _dependent_cells(view: PlaneView, material: Bool[np.ndarray, "r c"], away: Float[np.ndarray, " n"]) -> float:
    """Return how many cells are worth one, from the correlation of the residuals along rows and columns."""
    grid = np.zeros(view.behind.shape)
    limit = 3.0 * _MAD_TO_SIGMA * float(np.median(np.abs(away)))
    grid[material] = np.clip(away, -limit, limit)
    variance = float((grid[material] ** 2).mean()) or 1.0
    sums = []
    for axis in (0, 1):
        total = 1.0
        for lag in range(1, min(_FARTHEST_LAG, grid.shape[axis] - 1) + 1):
            one, other = (
                np.take(grid, range(lag, grid.shape[axis]), axis),
                np.take(grid, range(grid.shape[axis] - lag), axis),
            )
            both = np.take(material, range(lag, grid.shape[axis]), axis) & np.take(
                material, range(grid.shape[axis] - lag), axis
            )
            if both.sum() < _LEAST_CELLS:
                break
            correlation = float((one * other)[both].mean()) / variance
            if correlation < _LEAST_CORRELATION:
                break
            total += 2.0 * correlation
        sums.append(total)
    return sums[0] * sums[1]
