"""How the traffic is put together: limbs and tubes, side profiles, wheels, and the model made of them.

Objects are built with x forwards, y to the left and the floor at z = 0, and centred on their bounding box at the end.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from jaxtyping import Float

from warehouse_sim.catalog.parts import Triple, fused, lofted, mesh_part, model_of, solid_part
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import make_transform, rotation_x
from warehouse_sim.geometry.solids import Outline, lathe, prism, unit_cylinder
from warehouse_sim.schema import ObjectModel, Part


def assembled(
    name: str,
    class_name: str,
    obj_id: int,
    parts: Sequence[Part],
    collision: Sequence[OrientedBox],
    mass: float,
    turns: int = 1,
) -> ObjectModel:
    """Return the model of ``parts`` standing on z = 0, one part a material, moved to the centre of its bounding box.

    Collision boxes that reach out of the bounding box are cut back to it.
    """
    whole = fused(parts)
    vertices = np.concatenate([part.mesh.vertices for part in whole])
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    centre = (low + high) / 2
    moved = tuple(
        Part(TriangleMesh(part.mesh.vertices - centre, part.mesh.faces), part.scale, part.T_object_part, part.material)
        for part in whole
    )
    T_centre = make_transform(translation=-centre)
    return model_of(
        name,
        class_name,
        obj_id,
        high - low,
        moved,
        tuple(_cut_back(OrientedBox(T_centre @ box.T_parent_box, box.size), (high - low) / 2) for box in collision),
        mass=mass,
        turns=turns,
    )


def centre_of(parts: Sequence[Part]) -> Float[np.ndarray, " 3"]:
    """Return the centre (m) of the box around ``parts``: where ``assembled`` puts the origin."""
    vertices = np.concatenate([part.mesh.vertices for part in fused(parts)])
    return np.asarray((vertices.min(axis=0) + vertices.max(axis=0)) / 2)


def tube(
    path: Sequence[Triple] | Float[np.ndarray, "n 3"],
    radii: Sequence[Sequence[float]] | Float[np.ndarray, "n 2"],
    side: Triple = (0.0, 1.0, 0.0),
    sides: int = 16,
) -> TriangleMesh:
    """Return a closed body of elliptic sections along a path.

    Args:
        path: Centres of the sections (m), n points.
        radii: Half widths (m) of each section, first across ``side``, then along it.
        side: Direction that is never along the path; sections are turned so that one axis lies in it.
        sides: Corners of a section.
    """
    centres = np.asarray(path, dtype=float)
    along = np.gradient(centres, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    second = np.asarray(side, dtype=float) - along * (along @ np.asarray(side, dtype=float))[:, None]
    second /= np.linalg.norm(second, axis=1, keepdims=True)
    first = np.cross(second, along)
    turn = np.arange(sides) * (2 * np.pi / sides)
    size = np.asarray(radii, dtype=float)
    rings = (
        centres[:, None]
        + np.cos(turn)[None, :, None] * (size[:, :1] * first)[:, None]
        + np.sin(turn)[None, :, None] * (size[:, 1:] * second)[:, None]
    )
    return lofted(rings)


def smoothed(rows: Float[np.ndarray, "n k"], between: int) -> Float[np.ndarray, "m k"]:
    """Return ``rows`` with ``between`` more between each two, on curves that overshoot nothing (Fritsch, Carlson 1980).

    Rows are as far apart along the curve as their first three columns are, or evenly where these repeat.
    """
    if between == 0 or len(rows) < 3:
        return rows
    from scipy.interpolate import PchipInterpolator  # slow to import, and names need no shapes

    steps = np.linalg.norm(np.diff(rows[:, :3], axis=0), axis=1)
    at = np.concatenate([[0.0], np.cumsum(np.maximum(steps, 1e-6))])
    dense = np.concatenate([np.linspace(a, b, between + 1, endpoint=False) for a, b in pairwise(at)] + [at[-1:]])
    return np.asarray(PchipInterpolator(at, rows, axis=0)(dense))


def rod(start: Triple, end: Triple, radius: float, sides: int = 12) -> TriangleMesh:
    """Return a straight round bar."""
    step = np.asarray(end, dtype=float) - np.asarray(start, dtype=float)
    # Any direction across the bar will do.
    side = np.eye(3)[int(np.argmin(np.abs(step)))]
    return tube([start, end], [(radius, radius)] * 2, side, sides)


def side_profile(outline: Outline, width: float, material: str, y: float = 0.0) -> Part:
    """Return a plate or body whose side view is ``outline`` (x, z; counter-clockwise seen from the right, -y)."""
    return mesh_part(prism(outline, width), material, (0.0, y, 0.0), rotation_x(np.pi / 2))


def wheel(centre: Triple, diameter: float, width: float, rim: str = "truck_grey", tyre: str = "rubber") -> list[Part]:
    """Return a tyre and its rim, rolling along x."""
    across = rotation_x(np.pi / 2)
    return [
        solid_part(unit_cylinder(24), (diameter, diameter, width), centre, tyre, across),
        solid_part(unit_cylinder(16), (0.55 * diameter, 0.55 * diameter, width + 0.012), centre, rim, across),
    ]


def limb_box(start: Triple, end: Triple, radius: float, reach: float = 0.0) -> OrientedBox:
    """Return the box around a limb from ``start`` to ``end`` (m), ``reach`` longer at both ends."""
    a, b = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    length = float(np.linalg.norm(b - a))
    z = (b - a) / length
    x = np.cross([0.0, 1.0, 0.0], z)
    x /= np.linalg.norm(x)
    rotation = np.column_stack([x, np.cross(z, x), z])
    size = np.array([2 * radius, 2 * radius, length + 2 * reach])
    return OrientedBox(make_transform(rotation, (a + b) / 2), size)


def _cut_back(box: OrientedBox, half: Float[np.ndarray, " 3"]) -> OrientedBox:
    """Return ``box`` inside +-``half`` (m): cut there if it is parallel to the axes, else thinned until it fits."""
    if np.array_equal(box.T_parent_box[:3, :3], np.eye(3)):
        centre = box.T_parent_box[:3, 3]
        low, high = np.maximum(centre - box.size / 2, -half), np.minimum(centre + box.size / 2, half)
        return OrientedBox(make_transform(translation=(low + high) / 2), high - low)
    while np.any(np.abs(box.corners()) > half):
        box = OrientedBox(box.T_parent_box, box.size * [0.98, 0.98, 0.995])  # a limb stays about as long
    return box


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
        mesh_part(lathe(section, 40), tyre, centre, across),
        mesh_part(lathe(disc, 32), rim, centre, across),
    ]


def bar(points: list[Triple], radius: float, side: Triple = (0.0, 1.0, 0.0), sides: int = 16) -> TriangleMesh:
    """Return a round bar bent smoothly through ``points`` (m)."""
    path = smoothed(np.array(points, dtype=float), 4)
    return tube(path, [(radius, radius)] * len(path), side, sides)
