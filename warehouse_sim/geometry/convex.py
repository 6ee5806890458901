"""Convex outlines in the plane."""

import numpy as np
from jaxtyping import Float


def convex_hull(points: Float[np.ndarray, "n 2"]) -> Float[np.ndarray, "m 2"]:
    """Return the corners of the smallest convex outline around ``points``, counter-clockwise from the least x."""
    from scipy.spatial import ConvexHull  # slow to import, and few need it

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


def centroid(outline: Float[np.ndarray, "n 2"]) -> Float[np.ndarray, " 2"]:
    """Return the centre of area (m) of a counter-clockwise outline."""
    start, end = outline - outline[0], np.roll(outline - outline[0], -1, axis=0)
    cross = start[:, 0] * end[:, 1] - start[:, 1] * end[:, 0]
    return np.asarray(outline[0] + (cross[:, None] * (start + end)).sum(axis=0) / (3.0 * cross.sum()))


def shared(outline: Float[np.ndarray, "n 2"], other: Float[np.ndarray, "m 2"]) -> Float[np.ndarray, "k 2"]:
    """Return the outline of what two convex counter-clockwise outlines have in common; no rows where that is nothing.

    After I. E. Sutherland and G. W. Hodgman, "Reentrant polygon clipping" (Communications of the ACM 17(1), 1974).
    """
    left = outline
    for start, end in zip(other, np.roll(other, -1, axis=0), strict=True):
        if not len(left):
            break
        edge, after = end - start, np.roll(left, -1, axis=0)
        side, side_after = (edge[0] * (p[:, 1] - start[1]) - edge[1] * (p[:, 0] - start[0]) for p in (left, after))
        kept: list[np.ndarray] = []
        for point, follower, here, there in zip(left, after, side, side_after, strict=True):
            if here >= 0.0:
                kept.append(point)
            if here * there < 0.0:
                kept.append(point + (follower - point) * here / (here - there))
        left = np.array(kept).reshape(-1, 2)
    return left if len(left) >= 3 else np.empty((0, 2))
