"""Round and extruded solids: watertight, faces outward counter-clockwise, cached so that equal parts share one mesh.

All are centred on their bounding box and have their axis along z. Unit solids fill the cube of edge 1 m, so that a
part's scale is its outer size, as with ``mesh.unit_box``.
"""

from functools import cache
from itertools import pairwise

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.mesh import TriangleMesh

Outline = tuple[tuple[float, float], ...]
"""Corners (m) in order; a tuple, so that equal solids are made once."""


@cache
def unit_cylinder(segments: int = 24) -> TriangleMesh:
    """Return the cylinder of diameter and height 1 m; ``segments`` is a multiple of 4."""
    return lathe(((0.0, -0.5), (0.5, -0.5), (0.5, 0.5), (0.0, 0.5)), segments)


@cache
def unit_tube(inner: float, segments: int = 24) -> TriangleMesh:
    """Return the open pipe of outer diameter and height 1 m; ``inner`` is its inner diameter (m), 0-1."""
    return lathe(((inner / 2, -0.5), (0.5, -0.5), (0.5, 0.5), (inner / 2, 0.5)), segments)


@cache
def lathe(profile: Outline, segments: int = 24) -> TriangleMesh:
    """Turn a profile about the z axis.

    Args:
        profile: Points (radius, z) in m that run counter-clockwise around the solid's half section (radius to the
            right, z up). A profile that begins and ends on the axis makes a full body; one that stays off the axis is
            closed from its last point to its first and makes a ring.
        segments: Sides of the turned body, a multiple of 4, so that the outer size along x and y is exact.

    Raises:
        ValueError: ``segments`` is no multiple of 4, or only one end of the profile is on the axis.
    """
    if segments % 4 or segments < 4:
        raise ValueError(f"segments must be a multiple of 4, found {segments}")
    points = [point for i, point in enumerate(profile) if point != profile[i - 1]]
    on_axis = [radius <= 1e-12 for radius, _ in points]
    if on_axis[0] != on_axis[-1]:
        raise ValueError("a profile must begin and end on the axis, or stay off it")
    vertices: list[tuple[float, float, float]] = []
    rows: list[list[int]] = []
    for (radius, z), is_pole in zip(points, on_axis, strict=True):
        first = len(vertices)
        if is_pole:
            vertices.append((0.0, 0.0, z))
            rows.append([first] * segments)
        else:
            vertices += [(radius * c, radius * s, z) for c, s in _directions(segments)]
            rows.append(list(range(first, first + segments)))
    bands = list(pairwise(rows)) + ([] if on_axis[0] else [(rows[-1], rows[0])])
    return TriangleMesh(np.array(vertices), _band_faces(bands))


@cache
def prism(outline: Outline, height: float = 1.0) -> TriangleMesh:
    """Extrude a simple polygon along z, from -height / 2 to height / 2 (m).

    Args:
        outline: Corners (x, y) in m, counter-clockwise seen from +z; may be concave, may not cross itself.
        height: Length of the prism (m).

    Raises:
        ValueError: The outline runs clockwise or crosses itself.
    """
    corners, count = np.array(outline, dtype=float), len(outline)
    cap = _ears(corners)
    sides = [(i, j, j + count, i, j + count, i + count) for i, j in ((i, (i + 1) % count) for i in range(count))]
    faces = np.concatenate([cap[:, ::-1], cap + count, np.array(sides).reshape(-1, 3)])
    level = np.repeat([-height / 2, height / 2], count)
    return TriangleMesh(np.column_stack([np.tile(corners, (2, 1)), level]), faces.astype(np.int32))


@cache
def superellipsoid(
    side: float = 4.0, profile: float = 2.5, segments: int = 32, rings: int = 12, dent: float = 0.0
) -> TriangleMesh:
    """Return a rounded block that fills the cube of edge 1 m (Barr 1981, superquadrics).

    Args:
        side: Exponent of the outline seen from above: 2 is a circle, larger values come near a square.
        profile: Exponent of the section: 2 is a ball, larger values come near a brick.
        segments: Points around, a multiple of 4.
        rings: Bands from pole to pole, even.
        dent: How far the pole regions are pressed in, as a fraction of the half height, 0-0.5.
    """
    around = np.array([(_power(c, 2 / side), _power(s, 2 / side)) for c, s in _directions(segments)])
    vertices: list[np.ndarray] = []
    rows: list[list[int]] = []
    for angle in _right_angles(-1.0, 1.0, rings):
        radius, z = _power(np.cos(angle), 2 / profile), _power(np.sin(angle), 2 / profile)
        first = sum(map(len, vertices))
        block = np.column_stack([around * radius, np.full(segments, z * (1.0 - dent * (1.0 - radius) ** 2))]) / 2
        vertices.append(block if radius > 1e-9 else block[:1])
        rows.append(list(range(first, first + segments)) if radius > 1e-9 else [first] * segments)
    mesh = TriangleMesh(np.concatenate(vertices), _band_faces(list(pairwise(rows))))
    extent = np.ptp(mesh.vertices, axis=0)
    return TriangleMesh(mesh.vertices / extent, mesh.faces)


def _right_angles(start: float, stop: float, count: int) -> Float[np.ndarray, " n"]:
    """Return ``count + 1`` angles (rad) between multiples of a right angle."""
    return np.linspace(start, stop, count + 1) * (np.pi / 2)


def _directions(segments: int) -> list[tuple[float, float]]:
    """Return cosine and sine of equal turns; a quarter turn maps the set onto itself without rounding."""
    quarter = [(np.cos(a), np.sin(a)) for a in np.arange(segments // 4) * (2 * np.pi / segments)]
    turns = ((1, 0, 0, 1), (0, -1, 1, 0), (-1, 0, 0, -1), (0, 1, -1, 0))
    return [(a * c + b * s, d * c + e * s) for a, b, d, e in turns for c, s in quarter]


def _power(value: float, exponent: float) -> float:
    """Return ``value`` to the power ``exponent`` with its sign kept; rounding noise about zero is zero."""
    return float(np.sign(value) * np.abs(value) ** exponent) if abs(value) > 1e-12 else 0.0


def _band_faces(bands: list[tuple[list[int], list[int]]]) -> np.ndarray:
    """Return the triangles between pairs of rings; a ring of one repeated index is a pole."""
    faces = []
    for low, high in bands:
        for i in range(len(low)):
            j = (i + 1) % len(low)
            quad = ((low[i], low[j], high[j]), (low[i], high[j], high[i]))
            faces += [face for face in quad if len(set(face)) == 3]
    return np.array(faces, dtype=np.int32)


def _ears(corners: Float[np.ndarray, "n 2"]) -> np.ndarray:
    """Cut a simple counter-clockwise polygon into triangles by clipping ears (Meisters 1975)."""
    left, faces = list(range(len(corners))), []
    while len(left) > 3:
        for i, b in enumerate(left):
            a, c = left[i - 1], left[(i + 1) % len(left)]
            others = corners[[k for k in left if k not in (a, b, c)]]
            if _turn(corners[a], corners[b], corners[c][None])[0] > 0 and not _inside(corners[[a, b, c]], others).any():
                faces.append((a, b, c))
                left.pop(i)
                break
        else:
            raise ValueError("an outline must run counter-clockwise and not cross itself")
    if _turn(corners[left[0]], corners[left[1]], corners[[left[2]]])[0] <= 0:
        raise ValueError("an outline must run counter-clockwise and not cross itself")
    return np.array([*faces, left])


def _turn(
    a: Float[np.ndarray, " 2"], b: Float[np.ndarray, " 2"], points: Float[np.ndarray, "n 2"]
) -> Float[np.ndarray, " n"]:
    """Return twice the signed area of (a, b, point), > 0 to the left of the line from a to b."""
    return (b[0] - a[0]) * (points[:, 1] - a[1]) - (b[1] - a[1]) * (points[:, 0] - a[0])


def _inside(triangle: Float[np.ndarray, "3 2"], points: Float[np.ndarray, "n 2"]) -> np.ndarray:
    """Return which points lie in a counter-clockwise triangle or on its border."""
    return np.all([_turn(triangle[i - 1], triangle[i], points) >= 0 for i in range(3)], axis=0)
