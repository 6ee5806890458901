"""A depth image as it looks from before a plane: what each place of the plane is known to be.

Readings are carried to a grid in the plane. There each one is on the plane, behind it (the camera looks through an
opening, or past the object), before it (something covers it), or missing.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.geometry.pose import Transform, invert, transform_points

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
