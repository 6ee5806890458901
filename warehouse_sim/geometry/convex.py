"""Convex outlines in the plane."""

import numpy as np
from jaxtyping import Float
from scipy.spatial import ConvexHull


def convex_hull(points: Float[np.ndarray, "n 2"]) -> Float[np.ndarray, "m 2"]:
    """Return the corners of the smallest convex outline around ``points``, counter-clockwise from the least x."""
    ordered = np.unique(np.round(points, 9), axis=0)
    corners = ConvexHull(ordered).vertices
    return ordered[np.roll(corners, -int(corners.argmin()))]


def grown(outline: Float[np.ndarray, "n 2"], distance: float) -> Float[np.ndarray, "n 2"]:
    """Return a convex counter-clockwise outline whose edges lie ``distance`` (m) further out; corners stay sharp."""
    along = np.roll(outline, -1, axis=0) - outline
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    out = np.column_stack([along[:, 1], -along[:, 0]])
    before = np.roll(out, 1, axis=0)
    # The corner moves along the sum of its edges' normals n by d / (1 + n1.n2).
    return outline + distance * (out + before) / (1.0 + (out * before).sum(axis=1, keepdims=True))


def area(outline: Float[np.ndarray, "n 2"]) -> float:
    """Return the area (m^2) of a counter-clockwise outline."""
    x, y = outline.T
    return float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2
