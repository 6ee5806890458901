"""What trucks have in common: forks, mast, load carriage, overhead guard, seat and steering wheel.

Truck frame while building: x forwards with the forks' faces at x = 0, y left, z up from the floor.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from warehouse_sim.catalog.parts import Triple, box_part, mesh_part, solid_part
from warehouse_sim.catalog.traffic.shapes import rod, side_profile, tube
from warehouse_sim.geometry.pose import rotation_y
from warehouse_sim.geometry.solids import lathe, superellipsoid, unit_cylinder
from warehouse_sim.schema import Part

FORK_LENGTH, FORK_WIDTH, FORK_THICKNESS = 1.15, 0.10, 0.04
"""Blade of a fork arm (m): 40 x 100 x 1150, the usual size for class 2A carriages up to 2 t (ISO 2328, ISO 2330)."""
FORK_SPREAD = 0.43
"""Distance between the forks' middles (m); both enter the pockets of all EPAL faces."""


@dataclass(frozen=True)
class Mast:
    """Measures of a lowered mast (m)."""

    height: float
    """Top above the floor."""
    width: float
    """Outer width over the channels."""
    front: float
    """x of the front of the channels, behind the forks' faces."""
    stages: int
    """Pairs of channels, 2 or 3."""


def fork_pair(height: float) -> list[Part]:
    """Return two fork arms, hook to tip, whose blades lie with the top at ``height`` (m)."""
    low, heel = height - FORK_THICKNESS, -FORK_THICKNESS
    tip = 0.012
    outline = (
        (heel, low),
        (0.75 * FORK_LENGTH, low),
        (FORK_LENGTH, height - tip),
        (FORK_LENGTH, height),
        (0.0, height),
        (0.0, height + 0.56),
        (heel, height + 0.56),
    )
    return [side_profile(outline, FORK_WIDTH, "fork_steel", side * FORK_SPREAD / 2) for side in (-1.0, 1.0)]


def carriage(height: float, width: float) -> list[Part]:
    """Return the fork carriage of ``width`` (m) with its load backrest, for forks with the top at ``height`` (m)."""
    x = -FORK_THICKNESS - 0.02
    parts = [box_part((0.04, width, 0.10), (x, 0.0, height + z), "mast_black") for z in (0.10, 0.48)]
    foot, top = height + 0.53, height + 1.15
    for y in np.linspace(-0.5, 0.5, 7) * (width - 0.04):
        parts.append(box_part((0.03, 0.03, top - foot), (x, y, (foot + top) / 2), "mast_black"))
    parts.append(box_part((0.04, width, 0.04), (x, 0.0, top + 0.02), "mast_black"))
    return parts


def mast(kind: Mast) -> list[Part]:
    """Return the channels, ties, lift cylinders and chains of a lowered mast."""
    depth, web = 0.10, 0.045
    parts, low = [], 0.06
    for stage in range(kind.stages):
        half = kind.width / 2 - web / 2 - stage * (web + 0.006)
        x = kind.front - depth / 2 - 0.012 * (kind.stages - 1 - stage)
        top = kind.height - 0.03 * stage
        for side in (-1.0, 1.0):
            parts.append(box_part((depth, web, top - low), (x, side * half, (top + low) / 2), "mast_black"))
        for z in (top - 0.05, 0.55 * top, 0.30):
            if stage == 0 or z == top - 0.05:
                back = x - depth / 2 + 0.01
                parts.append(box_part((0.025, 2 * half, 0.10), (back, 0.0, z), "mast_black"))
    inner = kind.width / 2 - kind.stages * (web + 0.006) - 0.04
    for side in (-1.0, 1.0):
        x, top = kind.front - 0.07, 0.92 * kind.height
        parts.append(mesh_part(rod((x, side * inner, 0.12), (x, side * inner, 0.55 * top), 0.028), "mast_black"))
        parts.append(mesh_part(rod((x, side * inner, 0.55 * top), (x, side * inner, top), 0.018), "chrome"))
        parts.append(box_part((0.012, 0.03, 0.7 * top), (x + 0.045, side * (inner - 0.06), 0.6 * top), "fork_steel"))
    return parts


def overhead_guard(
    posts: Sequence[tuple[Triple, Triple]], roof: tuple[float, float, float, float], height: float, material: str
) -> list[Part]:
    """Return a guard on ``posts`` (foot and head on the left; the right ones are their mirror images).

    Args:
        posts: Foot and head (m) of each left post.
        roof: Back x, front x and half widths at back and front of the roof's frame (m).
        height: Top of the roof (m).
        material: Of posts and roof.
    """
    parts = []
    for foot, head in posts:
        for side in (1.0, -1.0):
            a, b = np.array(foot) * [1.0, side, 1.0], np.array(head) * [1.0, side, 1.0]
            parts.append(mesh_part(tube([a, b], [(0.035, 0.028)] * 2, sides=8), material))
    back, front, half_back, half_front = roof
    z = height - 0.035
    for side in (1.0, -1.0):
        edge = [(back, side * half_back, z), (front, side * half_front, z)]
        parts.append(mesh_part(tube(edge, [(0.035, 0.03)] * 2, sides=8), material))
    for x, half in ((back, half_back), (front, half_front)):
        parts.append(box_part((0.06, 2 * half, 0.06), (x, 0.0, z), material))
    for x in np.linspace(back, front, 8)[1:-1]:
        half = np.interp(x, [back, front], [half_back, half_front])
        parts.append(box_part((0.02, 2 * half, 0.045), (x, 0.0, z), material))
    return parts


def seat(x: float, z: float) -> list[Part]:
    """Return a driver's seat whose cushion has its front at ``x`` and its underside at ``z`` (m)."""
    cushion, back = superellipsoid(5.0, 3.5, 24, 8), superellipsoid(4.0, 3.5, 24, 8)
    return [
        solid_part(cushion, (0.48, 0.47, 0.15), (x - 0.24, 0.0, z + 0.075), "mast_black"),
        solid_part(back, (0.14, 0.46, 0.56), (x - 0.47, 0.0, z + 0.36), "mast_black", rotation_y(-0.2)),
        *(box_part((0.28, 0.06, 0.05), (x - 0.30, s * 0.27, z + 0.24), "mast_black") for s in (-1.0, 1.0)),
    ]


def steering(foot: Triple, hub: Triple) -> list[Part]:
    """Return a steering column from ``foot`` to ``hub`` (m) with a wheel of 320 mm across it."""
    a, b = np.asarray(foot, dtype=float), np.asarray(hub, dtype=float)
    axis = (b - a) / np.linalg.norm(b - a)
    tilt = rotation_y(np.arctan2(axis[0], axis[2]))
    ring = tuple((0.148 + 0.013 * np.cos(t), 0.013 * np.sin(t)) for t in np.arange(8) * (np.pi / 4))
    wheel = [
        mesh_part(lathe(ring, 24), "mast_black", b, tilt),
        solid_part(unit_cylinder(12), (0.06, 0.06, 0.03), b, "mast_black", tilt),
        *(box_part(size, b, "mast_black", tilt) for size in ((0.29, 0.025, 0.012), (0.025, 0.29, 0.012))),
    ]
    return [mesh_part(rod(a, b, 0.03), "mast_black"), *wheel]


def headlights(x: float, y: float, z: float) -> list[Part]:
    """Return two headlights, looking forwards from ``x``, at +-``y`` and ``z`` (m)."""
    housing, glass = superellipsoid(3.0, 3.0, 16, 6), unit_cylinder(16)
    along = rotation_y(np.pi / 2)
    parts = []
    for side in (-1.0, 1.0):
        parts.append(solid_part(housing, (0.09, 0.12, 0.12), (x - 0.03, side * y, z), "mast_black"))
        parts.append(solid_part(glass, (0.09, 0.09, 0.02), (x + 0.012, side * y, z), "sign_white", along))
    return parts


def beacon(x: float, y: float, z: float) -> list[Part]:
    """Return an orange beacon standing on ``z`` (m)."""
    dome = lathe(((0.0, -0.05), (0.055, -0.05), (0.055, 0.01), (0.04, 0.04), (0.0, 0.05)), 16)
    return [mesh_part(dome, "lamp_orange", (x, y, z + 0.05))]
