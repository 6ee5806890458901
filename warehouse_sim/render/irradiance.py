"""Light that arrives after at least one reflection, or from the sky: gathered once a scene on a grid of points.

What a point's rays hit is lit by the lights, with shadows, and, bounce after bounce, by what the points nearest to it
have gathered themselves; rays that leave the scene see an even sky. A point keeps the irradiance of six surfaces that
could lie there, looking along the axes (the "ambient cube" of McTaggart 2004, "Half-Life 2 / Valve source shading"),
which is exact for the walls, shelves and cartons that fill a warehouse.

Glowing materials light nothing here: in a warehouse they are the faces of luminaires, and those are lights already.

The light meter of ``generation`` solves the same equation and stays apart: it is an instrument, this is a part of a
image. The meter asks for a few points of exact triangles by random walks, to scale the lights and to label targets,
and must not change with what draws; this needs thousands of points at once, on coarse geometry, smooth enough for the
eye and cheap enough for every scene. They share the falloff of lights (``photometry``), the ground's share of the sky
(``light_selection.GROUND``) and the one binding of Embree, so that a light means the same to both.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Float32, Int

from warehouse_sim.render.light_grid import CoarseScene, LightGrid, lay_grid, neighbours
from warehouse_sim.render.light_selection import GROUND, light_geometry
from warehouse_sim.scene.lighting.photometry import relative_intensity
from warehouse_sim.schema import Light, SceneSpec

AXES = np.concatenate([np.eye(3), -np.eye(3)]).astype(np.float32)
"""Directions that the six values of a point look along: x, y, z, -x, -y, -z."""
_BOUNCES = 3  # computed; those that follow are taken for a geometric series
_NO_TRUST = 1e-3  # weight of a point that lies inside something
_SHARE = np.float32(0.4)  # of a neighbour in the mean that a point becomes
_REACH = 4  # points that values are carried into things


@dataclass(frozen=True, eq=False)
class IrradianceField:
    """Indirect irradiance on a grid of points in the world."""

    origin: Float[np.ndarray, "3"]
    """First point (m)."""
    spacing: Float[np.ndarray, "3"]
    """Distance between points along each axis (m)."""
    irradiance: Float32[np.ndarray, "nx ny nz 6 3"]
    """Linear RGB (lx) on a surface that looks along each of ``AXES``."""
    weight: Float32[np.ndarray, "nx ny nz"]
    """Trust in each point: 1 in the open; nearly 0 inside things, where the values are those of neighbours."""


class LightGatherer:
    """Computes fields of one scene's geometry under any lights; a light that has not moved is not cast again.

    Args:
        scene: What stands in it and how it is painted count, its lights do not.

    Raises:
        MissingPackageError: Embree is not installed.
    """

    def __init__(self, scene: SceneSpec) -> None:
        self._grid = lay_grid(scene)
        self._reaches: dict[bytes, LightReach] = {}

    def field(self, lights: Sequence[Light], ambient: float) -> IrradianceField:
        """Return the field under ``lights`` and an even sky that gives an upward surface ``ambient`` lx."""
        grid = self._grid
        sky = np.where(grid.rays[..., 2] >= 0.0, 1.0, GROUND) * ambient / np.pi
        luminance = np.where(grid.escaped, sky, 0.0)[..., None].repeat(3, axis=2).astype(np.float32)
        direct = direct_irradiance(grid.solid, lights, grid.places, grid.normals, self._reaches)
        cubes = _smoothed(_all_bounces(grid, luminance, direct).reshape(*grid.shape, 6, 3), grid)
        weight = np.where(grid.trusted, 1.0, _NO_TRUST).astype(np.float32)
        return IrradianceField(grid.origin, grid.spacing, cubes, weight)


@dataclass(frozen=True, eq=False)
class LightReach:
    """What one light reaches among some points, however bright it is."""

    lit: Int[np.ndarray, " k"]
    """Numbers of the points that it lights."""
    share: Float32[np.ndarray, " k"]
    """Their irradiance (lx) for each candela of the light."""


def direct_irradiance(
    solid: CoarseScene,
    lights: Sequence[Light],
    points: Float[np.ndarray, "n 3"],
    normals: Float[np.ndarray, "n 3"],
    reaches: dict[bytes, LightReach] | None = None,
) -> Float32[np.ndarray, "n 3"]:
    """Return the irradiance (lx, linear RGB) that lights, taken for points, give surfaces.

    Args:
        solid: Casts the shadows.
        lights: The lights.
        points: On the surfaces, a little lifted (m).
        normals: Unit normals of the surfaces.
        reaches: What lights reach among these very points, by ``light_geometry``; those that are new are added.
    """
    known = {} if reaches is None else reaches
    total = np.zeros((len(points), 3), np.float32)
    for light in lights:
        key = light_geometry(light)
        if key not in known:
            known[key] = _reach_of(light, solid, points, normals)
        reach = known[key]
        total[reach.lit] += light.intensity * reach.share[:, None] * np.asarray(light.color, np.float32)
    return total


def _reach_of(
    light: Light, solid: CoarseScene, points: Float[np.ndarray, "n 3"], normals: Float[np.ndarray, "n 3"]
) -> LightReach:
    """Return what a light reaches: cos(incidence) / r^2; a spot fades as glTF's KHR_lights_punctual says."""
    to_light = (np.asarray(light.position, float) - points).astype(np.float32)
    squared = np.einsum("ij,ij->i", to_light, to_light)
    distance = np.sqrt(squared)
    share = np.einsum("ij,ij->i", to_light, normals) / (distance * squared)
    cosine = np.einsum("ij,j->i", to_light, -np.asarray(light.direction, np.float32)) / distance
    share *= relative_intensity(light, cosine)
    lit = np.flatnonzero(share > 0.0)
    if light.casts_shadow:
        lit = lit[~solid.blocked(points[lit], to_light[lit])]
    return LightReach(lit, share[lit].astype(np.float32))


def _all_bounces(
    grid: LightGrid, luminance: Float32[np.ndarray, "p j 3"], direct: Float32[np.ndarray, "n 3"]
) -> Float32[np.ndarray, "p 6 3"]:
    """Return the irradiance along ``AXES`` of each point.

    Args:
        grid: Points and rays.
        luminance: Of the sky where a ray leaves the scene (cd/m^2), else zero; the rest is filled in.
        direct: Irradiance from the lights where rays hit (lx).
    """
    kernel = np.maximum(grid.rays @ AXES.T, 0.0)
    kernel *= np.pi / kernel.sum(axis=1, keepdims=True)  # an even environment of luminance 1 gives exactly pi
    # A surface sees three of the six values of the point before it, by the squares of its normal.
    share = grid.normals**2
    places = grid.nearest[:, None] * 6 + np.where(grid.normals >= 0.0, [0, 1, 2], [3, 4, 5])
    before = after = np.zeros((len(luminance), 6, 3), np.float32)
    totals = [0.0]
    for _ in range(_BOUNCES):
        before, table = after, after.reshape(-1, 3)
        arriving = sum((table[places[:, axis]] * share[:, axis, None] for axis in range(3)), start=direct)
        luminance.reshape(-1, 3)[grid.hit] = grid.albedo / np.float32(np.pi) * arriving
        after = _filled(np.swapaxes(kernel, 1, 2) @ luminance, grid.trusted)
        totals.append(float(after.mean(dtype=np.float64)))
    earlier, gain = np.diff(totals)[-2:]
    ratio = min(max(gain / earlier, 0.0), 0.95) if earlier > 0.0 else 0.0
    return after + (after - before) * np.float32(ratio / (1.0 - ratio))


def _smoothed(cubes: Float32[np.ndarray, "nx ny nz 6 3"], grid: LightGrid) -> Float32[np.ndarray, "nx ny nz 6 3"]:
    """Return the mean of each point and those neighbours that it sees, which evens out what few rays have missed."""
    trusted = grid.trusted.astype(np.float32)[..., None, None]
    weights = np.maximum(trusted, _NO_TRUST)
    sums = cubes * weights
    for axis, way in enumerate(grid.ways):
        near, far = neighbours(axis)
        joined = _SHARE * way[..., None, None]
        for here, there in ((near, far), (far, near)):
            sums[here] += joined * trusted[there] * cubes[there]
            weights[here] += joined * trusted[there]
    return sums / weights


def _filled(cubes: Float32[np.ndarray, "p 6 3"], trusted: Bool[np.ndarray, "nx ny nz"]) -> Float32[np.ndarray, "p 6 3"]:
    """Return ``cubes`` with those of points inside things replaced by the mean of neighbours, from outside inwards."""
    weight = np.pad(trusted.astype(np.float32), 1)[..., None]
    values = np.pad(cubes.reshape(*trusted.shape, 18), ((1, 1), (1, 1), (1, 1), (0, 0))) * weight
    middle = (slice(1, -1),) * 3
    for _ in range(_REACH):
        near_values, near_weight = np.zeros_like(values[middle]), np.zeros_like(weight[middle])
        for axis in range(3):
            for shift in (-1, 1):
                near_values += np.roll(values, shift, axis)[middle]
                near_weight += np.roll(weight, shift, axis)[middle]
        gained = (weight[middle] == 0.0) & (near_weight > 0.0)
        values[middle] = np.where(gained, near_values / np.maximum(near_weight, 1.0), values[middle])
        weight[middle] = np.where(gained, 1.0, weight[middle])
    return values[middle].reshape(cubes.shape)
