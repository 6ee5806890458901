"""Light that arrives after at least one reflection, or from the sky: gathered once a scene on a grid of points.

What a point's rays hit is lit by the lights, with shadows, and, bounce after bounce, by what the points nearest to it
have gathered themselves; rays that leave the scene see an even sky. A point keeps the irradiance of six surfaces that
could lie there, looking along the axes (the "ambient cube" of McTaggart 2004, "Half-Life 2 / Valve source shading"),
which is exact for the walls, shelves and cartons that fill a warehouse.

Glowing materials light nothing here: in a warehouse they are the faces of luminaires, and those are lights already.

The light meter of ``generation`` solves the same equation and stays apart: it is an instrument, this is a part of a
image. The meter requires a few points of exact triangles by random walks, to scale the lights and to label targets,
and must not change with what draws; this needs thousands of points at once, on coarse geometry, smooth enough for the
eye and cheap enough for every scene. They share the falloff of lights (``photometry``), the ground's fraction of the
sky (``light_selection.GROUND``) and the one binding of Embree, so that a light means the same to both.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Float32, Int

from warehouse_sim.render.hall_probe import hall_probe
from warehouse_sim.render.light_grid import RAYS, GridLevel, LightGrid, neighbours
from warehouse_sim.render.light_selection import GROUND, LightReach, direct_irradiance, light_reaches
from warehouse_sim.schema import Light

AXES = np.concatenate([np.eye(3), -np.eye(3)]).astype(np.float32)
"""Directions that the six values of a point look along: x, y, z, -x, -y, -z."""
FARTHEST_REACH = 1.5
"""Spacings beyond which nothing is interpolated between points, and a little more."""
_CONE = 0.8  # cosine with an axis of the rays that tell how far a point sees along it
_BOUNCES = 8  # followed
_FRACTIONS = 3  # that the rays are split into, one for each bounce in turn
_NO_TRUST = 1e-3  # weight of a point that lies inside something
_FRACTION = np.float32(0.4)  # of a neighbour in the mean that a point becomes
_REACH = 4  # points that values are carried into things


@dataclass(frozen=True, eq=False)
class FieldLevel:
    """Indirect irradiance on a grid of points in the world."""

    origin: Float[np.ndarray, "3"]
    """First point (m)."""
    spacing: Float[np.ndarray, "3"]
    """Distance between points along each axis (m)."""
    irradiance: Float32[np.ndarray, "nx ny nz 6 3"]
    """Linear RGB (lx) on a surface that looks along each of ``AXES``."""
    weight: Float32[np.ndarray, "nx ny nz"]
    """Trust in each point: 1 in the open; nearly 0 inside things, where the values are those of neighbours."""
    cut: Bool[np.ndarray, "2 3"]
    """On which of its low and high sides what is seen goes on beyond it."""
    reach: Float32[np.ndarray, "nx ny nz 6"]
    """How far along each of ``AXES`` (m) a point sees on average, at most ``FARTHEST_REACH`` spacings."""


@dataclass(frozen=True, eq=False)
class IrradianceField:
    """Indirect irradiance all over a scene."""

    levels: tuple[FieldLevel, ...]
    """The finest first; the last covers all that can be seen."""
    probe: Float32[np.ndarray, "levels rows columns"]
    """Factors of ``hall_probe`` on what is mirrored."""


class LightGatherer:
    """Computes fields of one scene's geometry under any lights; a light that has not moved is not cast again.

    Args:
        grid: That of the scene: what stands in it and how it is painted count, its lights do not.
    """

    def __init__(self, grid: LightGrid) -> None:
        self._grid = grid
        self._reaches: dict[bytes, LightReach] = {}
        self._fills: dict[bytes, LightReach] = {}

    def field(self, lights: Sequence[Light], ambient: float) -> IrradianceField:
        """Return the field under ``lights`` and an even sky that gives an upward surface ``ambient`` lx."""
        grid = self._grid
        sky = np.where(grid.rays[..., 2] >= 0.0, 1.0, GROUND) * ambient / np.pi
        luminance = np.where(np.isinf(grid.distance), sky, 0.0)[..., None].repeat(3, axis=2).astype(np.float32)
        points = np.concatenate([level.points for level in grid.levels])
        direct = direct_irradiance(grid.solid, lights, grid.places, grid.normals, self._reaches)
        wide = light_reaches(grid.solid, lights, points, None, self._fills)
        cubes = _all_bounces(grid, luminance, direct) + _gathered_directly(grid, points, lights, wide)
        levels = tuple(_field_level(grid, level, cubes[level.rows]) for level in grid.levels)
        return IrradianceField(levels, hall_probe(grid, [level.irradiance for level in levels], lights, ambient))


def _gathered_directly(
    grid: LightGrid, points: Float32[np.ndarray, "p 3"], lights: Sequence[Light], reaches: Sequence[LightReach]
) -> Float32[np.ndarray, "p 6 3"]:
    """Return the irradiance along ``AXES`` of each point straight from what no shadow map shows of the lights."""
    total = np.zeros((len(points), 6, 3), np.float32)
    for light, reach in zip(lights, reaches, strict=True):
        towards = light.position.astype(np.float32) - points[reach.lit]
        towards /= np.linalg.norm(towards, axis=1, keepdims=True)
        along = np.maximum(towards @ AXES.T, 0.0) * reach.fraction[:, None]
        total[reach.lit] += along[..., None] * (light.intensity * np.asarray(light.color, np.float32))
    return np.concatenate([_filled(total[level.rows], level.trusted) for level in grid.levels])


def _field_level(grid: LightGrid, level: GridLevel, cubes: Float32[np.ndarray, "p 6 3"]) -> FieldLevel:
    """Return what is known at the points of a level."""
    smooth = _smoothed(cubes.reshape(*level.shape, 6, 3), level)
    weight = np.where(level.trusted, 1.0, _NO_TRUST).astype(np.float32)
    return FieldLevel(level.origin, level.spacing, smooth, weight, level.cut, _reach_along_axes(grid, level))


def _reach_along_axes(grid: LightGrid, level: GridLevel) -> Float32[np.ndarray, "nx ny nz 6"]:
    """Return how far (m) along each of ``AXES`` the rays about it go, on average."""
    along = grid.rays[level.rows] @ AXES.T
    near = along > _CONE
    farthest = (FARTHEST_REACH * np.tile(level.spacing, 2)).astype(np.float32)
    gone = np.minimum(grid.distance[level.rows][..., None] * np.where(near, along, 1.0), farthest)
    return ((gone * near).sum(axis=1) / near.sum(axis=1)).reshape(*level.shape, 6).astype(np.float32)


@dataclass(frozen=True, eq=False)
class _RayFraction:
    """Some of the rays of each point, spread as evenly as all, and what they hit."""

    kernel: Float32[np.ndarray, "p 6 k"]
    """What each ray's luminance adds to the irradiance along ``AXES``."""
    sky: Float32[np.ndarray, "p k 3"]
    """Luminance that comes from outside of the scene (cd/m^2)."""
    slots: Int[np.ndarray, " n"]
    """Which rays hit a surface."""
    returned: Float32[np.ndarray, "n 3"]
    """Luminance of those surfaces by the lights alone (cd/m^2)."""
    albedo: Float32[np.ndarray, "n 3"]
    """Their luminance for each lux, linear RGB."""
    seen: Int[np.ndarray, "n 3"]
    """The values that reach them, of the six of all points in a row: those of the point before them."""
    fraction: Float32[np.ndarray, "n 3"]
    """By how much each counts: the squares of their normals."""

    def gather(self, grid: LightGrid, before: Float32[np.ndarray, "p 6 3"]) -> Float32[np.ndarray, "p 6 3"]:
        """Return the irradiance along ``AXES`` when ``before`` is what reaches surfaces beside the lights' light."""
        luminance, table = self.sky.copy(), before.reshape(-1, 3)
        arriving = sum(table[self.seen[:, axis]] * self.fraction[:, axis, None] for axis in range(3))
        luminance.reshape(-1, 3)[self.slots] = self.returned + self.albedo * arriving
        gathered = self.kernel @ luminance
        return np.concatenate([_filled(gathered[level.rows], level.trusted) for level in grid.levels])


def _ray_fraction(
    grid: LightGrid, sky: Float32[np.ndarray, "p j 3"], direct: Float32[np.ndarray, "n 3"], first: int, step: int
) -> _RayFraction:
    """Return every ``step``-th ray from ``first`` on; arguments as those of ``_all_bounces``."""
    kernel = np.maximum(grid.rays[:, first::step] @ AXES.T, 0.0)
    kernel *= np.pi / kernel.sum(axis=1, keepdims=True)  # an even environment of luminance 1 gives exactly pi
    point, ray = np.divmod(grid.hit, RAYS)
    rows = slice(None) if step == 1 else np.flatnonzero(ray % step == first)
    albedo, normals = grid.albedo[rows] / np.float32(np.pi), grid.normals[rows]
    return _RayFraction(
        kernel=np.ascontiguousarray(np.swapaxes(kernel, 1, 2)),
        sky=np.ascontiguousarray(sky[:, first::step]),
        slots=(point * kernel.shape[1] + ray // step)[rows],
        returned=albedo * direct[rows],
        albedo=albedo,
        seen=grid.nearest[rows, None] * 6 + np.where(normals >= 0.0, [0, 1, 2], [3, 4, 5]),
        fraction=normals**2,
    )


def _even_guess(
    grid: LightGrid, sky: Float32[np.ndarray, "p j 3"], direct: Float32[np.ndarray, "n 3"]
) -> Float32[np.ndarray, " 3"]:
    """Return the irradiance of a space that is lit evenly, as in an integrating sphere: where the bounces start from.

    Started from darkness, they would end a few percent too dark between pale walls.
    """
    counted = np.concatenate([level.trusted.ravel() for level in grid.levels])
    rows = counted[grid.hit // RAYS]
    rays = np.float32(max(int(counted.sum()) * RAYS, 1))
    gives = np.pi * sky[counted].sum(axis=(0, 1)) + (grid.albedo[rows] * direct[rows]).sum(axis=0)
    kept = np.minimum(grid.albedo[rows].sum(axis=0) / rays, np.float32(0.95))
    guess: Float32[np.ndarray, " 3"] = (gives / rays / (1.0 - kept)).astype(np.float32)
    return guess


def _all_bounces(
    grid: LightGrid, sky: Float32[np.ndarray, "p j 3"], direct: Float32[np.ndarray, "n 3"]
) -> Float32[np.ndarray, "p 6 3"]:
    """Return the irradiance along ``AXES`` of each point.

    Places far from all lamps live by many bounces: they are followed with some of the rays, and gathered by all.

    Args:
        grid: Points and rays.
        sky: Luminance where a ray leaves the scene (cd/m^2), else zero.
        direct: Irradiance from the lights where rays hit (lx).
    """
    fractions = [_ray_fraction(grid, sky, direct, number, _FRACTIONS) for number in range(_FRACTIONS)]
    values = np.broadcast_to(_even_guess(grid, sky, direct), (len(grid.rays), len(AXES), 3))
    for number in range(_BOUNCES):
        values = fractions[number % _FRACTIONS].gather(grid, values)
    return _ray_fraction(grid, sky, direct, 0, 1).gather(grid, values)


def _smoothed(cubes: Float32[np.ndarray, "nx ny nz 6 3"], level: GridLevel) -> Float32[np.ndarray, "nx ny nz 6 3"]:
    """Return the mean of each point and those neighbours that it sees, which evens out what few rays have missed."""
    trusted = level.trusted.astype(np.float32)[..., None, None]
    weights = np.maximum(trusted, _NO_TRUST)
    sums = cubes * weights
    for axis, way in enumerate(level.ways):
        near, far = neighbours(axis)
        joined = _FRACTION * way[..., None, None]
        for here, there in ((near, far), (far, near)):
            sums[here] += joined * trusted[there] * cubes[there]
            weights[here] += joined * trusted[there]
    return sums / weights


def _filled(cubes: Float32[np.ndarray, "p 6 3"], trusted: Bool[np.ndarray, "nx ny nz"]) -> Float32[np.ndarray, "p 6 3"]:
    """Return ``cubes`` with those of points inside things replaced by the mean of neighbours, from outside inwards."""
    weight = np.pad(trusted.astype(np.float32), 1)
    values = np.pad(cubes.reshape(*trusted.shape, 18), ((1, 1), (1, 1), (1, 1), (0, 0))) * weight[..., None]
    middle = (slice(1, -1),) * 3
    steps = [way * stride // weight.itemsize for stride in weight.strides for way in (1, -1)]
    known, rows = weight.reshape(-1), values.reshape(-1, 18)
    for _ in range(_REACH):
        empty = np.flatnonzero(np.pad(weight[middle] == 0.0, 1))
        near = np.sum([known[empty + step] for step in steps], axis=0)
        gained = empty[near > 0.0]
        mean = np.zeros((len(gained), 18), np.float32)
        for step in steps:
            mean += rows[gained + step]
        rows[gained] = mean / near[near > 0.0, None]
        known[gained] = 1.0
    return values[middle].reshape(cubes.shape)
