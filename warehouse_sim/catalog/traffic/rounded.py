"""Bodies without sharp edges: rounded side views, wheels with shoulders, thick bent bars."""

import numpy as np

from warehouse_sim.catalog.parts import Triple, solid_part
from warehouse_sim.catalog.traffic.shapes import side_profile, smoothed, tube
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import rotation_x
from warehouse_sim.geometry.solids import Outline, lathe
from warehouse_sim.schema import Part

_ARC = 5
"""Sides of a rounded corner."""


def rounded(outline: Outline, radius: float) -> Outline:
    """Return ``outline`` with its corners rounded to ``radius`` (m), less where the edges are too short for it."""
    corners = np.array(outline, dtype=float)
    points: list[tuple[float, float]] = []
    for before, here, after in zip(np.roll(corners, 1, axis=0), corners, np.roll(corners, -1, axis=0), strict=True):
        reach = min(radius, 0.45 * float(np.linalg.norm(before - here)), 0.45 * float(np.linalg.norm(after - here)))
        a = here + reach * (before - here) / np.linalg.norm(before - here)
        b = here + reach * (after - here) / np.linalg.norm(after - here)
        for t in np.linspace(0.0, 1.0, _ARC + 1):
            # A quadratic Bezier curve: tangent to both edges.
            x, z = (1 - t) ** 2 * a + 2 * t * (1 - t) * here + t**2 * b
            points.append((float(x), float(z)))
    return tuple(points)


def body(outline: Outline, width: float, material: str, y: float = 0.0, radius: float = 0.05) -> Part:
    """Return a body whose side view is ``outline`` (x, z; counter-clockwise from the right) with rounded corners."""
    return side_profile(rounded(outline, radius), width, material, y)


def round_wheel(
    centre: Triple, diameter: float, width: float, rim: str = "truck_grey", tyre: str = "rubber"
) -> list[Part]:
    """Return a tyre with rounded shoulders and a dished rim with a hub, rolling along x."""
    r, w, across = diameter / 2, width / 2, rotation_x(np.pi / 2)
    s = min(0.12 * r, 0.3 * w)
    section: Outline = (
        *((0.62 * r, -w), (r - s, -w), (r - 0.3 * s, -w + 0.3 * s), (r, -w + s)),
        *((r, w - s), (r - 0.3 * s, w - 0.3 * s), (r - s, w), (0.62 * r, w)),
    )
    disc: Outline = (
        *((0.0, -0.95 * w), (0.2 * r, -0.95 * w), (0.28 * r, -0.6 * w), (0.52 * r, -0.6 * w), (0.62 * r, -w)),
        *((0.62 * r, w), (0.52 * r, 0.6 * w), (0.28 * r, 0.6 * w), (0.2 * r, 0.95 * w), (0.0, 0.95 * w)),
    )
    return [
        solid_part(lathe(section, 40), (1.0, 1.0, 1.0), centre, tyre, across),
        solid_part(lathe(disc, 32), (1.0, 1.0, 1.0), centre, rim, across),
    ]


def bar(points: list[Triple], radius: float, side: Triple = (0.0, 1.0, 0.0), sides: int = 16) -> TriangleMesh:
    """Return a round bar bent smoothly through ``points`` (m)."""
    path = smoothed(np.array(points, dtype=float), 4)
    return tube(path, [(radius, radius)] * len(path), side, sides)
