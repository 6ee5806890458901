"""Points in a scene and all that rays from them hit: the geometry of light from the surroundings.

The points lie on two grids: a fine one where cameras may stand and a little beyond, and a coarse one over all that can
be seen from there.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Float32, Int

from warehouse_sim.render.coarse_scene import coarse_mesh
from warehouse_sim.render.embree import PlacedMeshes
from warehouse_sim.schema import SceneSpec

RAYS = 24
"""Rays from each point."""
_FARTHEST = (4.0, 150.0)  # metres from where cameras may stand that each grid reaches
_POINTS = (8000, 1000)  # of each grid, about
_SPACING = (0.4, 1.0)  # least distance between two points of each (m)
_PITCH = 2.0  # metres between the places that stand for an aisle, about
_HEIGHTS = (0.7, 2.0, 3.3)  # metres above its floor
_EYE_RAYS = 200  # directions from each such place that tell what can be seen
_AROUND, _ABOVE = 3.0, 1.0  # metres beside and over a target from where it may be looked at
_SIDES = 8  # of a target
_BESIDE = np.array([0.7, 0.7, 0.7])  # metres beside and above a scene smaller than that
_LIFT = 2e-3  # metres by which points on surfaces are lifted off them
_SOLID = 0.25  # fraction of rays that meet the inner side of a face from which on a point lies in something


@dataclass(frozen=True, eq=False)
class CoarseHits:
    """Where rays end; rows of rays that leave the scene hold an infinite distance and zeros."""

    distance: Float32[np.ndarray, " n"]
    """In units of the ray's direction."""
    normals: Float32[np.ndarray, "n 3"]
    """Unit outward normals in the world."""
    albedo: Float32[np.ndarray, "n 3"]
    """Fraction of light that is returned, linear RGB."""


class CoarseScene:
    """What turns light in a scene, in an acceleration structure of its own.

    Args:
        scene: The scene; film and the glow of luminaires are left out.

    Raises:
        MissingPackageError: Embree is not installed.
    """

    def __init__(self, scene: SceneSpec) -> None:
        mesh, albedo = coarse_mesh(scene)
        corners = mesh.vertices if len(mesh.faces) else np.zeros((1, 3))
        self.low = corners.min(axis=0)
        """Least corner of what turns light (m)."""
        self.high = corners.max(axis=0)
        """Greatest corner (m)."""
        # One extra row answers for rays that hit nothing, whose triangle number is -1.
        self._normals = np.concatenate([mesh.face_normals(), np.zeros((1, 3))]).astype(np.float32)
        self._albedo = np.concatenate([albedo, np.zeros((1, 3))]).astype(np.float32)
        self._meshes = PlacedMeshes([[mesh]], [(0, np.eye(4))])

    def cast(self, origins: Float[np.ndarray, "n 3"], directions: Float[np.ndarray, "n 3"]) -> CoarseHits:
        """Return what rays meet first.

        Args:
            origins: Starting points in the world (m).
            directions: Directions in the world, of any length.
        """
        hits = self._meshes.cast(origins, directions)
        return CoarseHits(hits.distance, self._normals[hits.triangle], self._albedo[hits.triangle])

    def blocked(
        self, origins: Float[np.ndarray, "n 3"], directions: Float[np.ndarray, "n 3"], reach: float = 1.0
    ) -> Bool[np.ndarray, " n"]:
        """Return whether anything lies on rays nearer than ``reach``, in units of the rays' directions."""
        return self._meshes.blocked(origins, directions, reach)


@dataclass(frozen=True, eq=False)
class GridLevel:
    """One regular grid."""

    origin: Float[np.ndarray, "3"]
    """First point in the world (m)."""
    spacing: Float[np.ndarray, "3"]
    """Distance between points along each axis (m)."""
    shape: tuple[int, int, int]
    """Number of points along each axis."""
    cut: Bool[np.ndarray, "2 3"]
    """On which of its low and high sides what is seen goes on beyond it."""
    first: int
    """Number of its first point among those of all levels."""
    ways: tuple[np.ndarray, np.ndarray, np.ndarray]
    """Along each axis, one shorter there: whether neighbours see each other."""
    trusted: Bool[np.ndarray, "nx ny nz"]
    """Which points lie in the open, and in sight of a place to look from, of a point that does, and so on."""

    @property
    def rows(self) -> slice:
        """Its points among those of all levels."""
        return slice(self.first, self.first + int(np.prod(self.shape)))

    @property
    def points(self) -> Float[np.ndarray, "n 3"]:
        """Its points in the world (m), in the order of ``rows``."""
        return _points_of(self.origin, self.spacing, self.shape).reshape(-1, 3)

    def cells(self, places: Float[np.ndarray, "n 3"]) -> Int[np.ndarray, "n 3"]:
        """Return the indices of the points nearest to ``places`` (m), also of such as lie outside."""
        return np.rint((places - self.origin) / self.spacing).astype(int)


@dataclass(frozen=True, eq=False)
class LightGrid:
    """Points, the rays that leave them, and the surfaces that the rays hit from outside."""

    solid: CoarseScene
    levels: tuple[GridLevel, ...]
    """The finest first."""
    rays: Float32[np.ndarray, "p j 3"]
    """Directions from each point; no two neighbours' are the same, so that they do not miss the same things."""
    distance: Float32[np.ndarray, "p j"]
    """Where they end (m); infinite where they leave the scene."""
    hit: Int[np.ndarray, " n"]
    """Which rays hit a surface: number of the point times ``RAYS`` plus that of the direction."""
    places: Float32[np.ndarray, "n 3"]
    """Where, lifted a little (m)."""
    normals: Float32[np.ndarray, "n 3"]
    albedo: Float32[np.ndarray, "n 3"]
    nearest: Int[np.ndarray, " n"]
    """The point that lies best before each surface."""


def lay_grid(scene: SceneSpec) -> LightGrid:
    """Cast the rays of ``scene``; where its viewpoints are does not matter.

    Raises:
        MissingPackageError: Embree is not installed.
    """
    solid = CoarseScene(scene)
    eyes = _eye_points(scene, solid)
    seen = _seen_from(eyes, solid)
    frames = [_extent(eyes, seen, solid, number) for number in range(len(_POINTS))]
    points = np.concatenate([_points_of(*frame[:3]).reshape(-1, 3) for frame in frames])
    rays = _directions(len(points))
    hits = solid.cast(np.repeat(points, RAYS, axis=0), rays.reshape(-1, 3))
    inner = np.einsum("nk,nk->n", hits.normals, rays.reshape(-1, 3)) > 0.0
    outside = inner.reshape(-1, RAYS).mean(axis=1) < _SOLID
    levels: list[GridLevel] = []
    for frame in frames:
        first = levels[-1].rows.stop if levels else 0
        open_points = outside[first : first + int(np.prod(frame[2]))].reshape(frame[2])
        ways = _open_ways(solid, _points_of(*frame[:3]))
        levels.append(GridLevel(*frame, first, ways, _trusted(frame, ways, open_points, eyes)))
    hit = np.flatnonzero(np.isfinite(hits.distance) & ~inner)
    normals = hits.normals[hit]
    places = points[hit // RAYS] + rays.reshape(-1, 3)[hit] * hits.distance[hit, None] + normals * np.float32(_LIFT)
    return LightGrid(
        solid, tuple(levels), rays, hits.distance.reshape(-1, RAYS), hit, places, normals, hits.albedo[hit],
        _nearest_points(levels, places, normals),
    )  # fmt: skip


def sphere_directions(
    count: int, shift: float | Float[np.ndarray, "p 1"] = 0.5
) -> Float32[np.ndarray, "n 3"] | Float32[np.ndarray, "p n 3"]:
    """Return ``count`` unit vectors spread evenly: the spherical Fibonacci lattice (Swinbank and Purser 2006).

    Args:
        count: Number of directions.
        shift: Where between the heights of two of them the first one lies, 0-1; one lattice for each.
    """
    k = np.arange(count)
    z, angle = 1.0 - 2.0 * (k + shift) / count, (k + 0.5) * np.pi * (1.0 + np.sqrt(5.0))
    ring = np.sqrt(1.0 - z * z)
    return np.stack([ring * np.cos(angle), ring * np.sin(angle), z], axis=-1).astype(np.float32)


def _directions(count: int) -> Float32[np.ndarray, "p j 3"]:
    """Return the rays of ``count`` points: lattices shifted and turned about z, each in another way.

    Heights and angles fill their square evenly: the R2 sequence (Roberts 2018).
    """
    number = np.arange(count)[:, None]
    rays = sphere_directions(RAYS, (number * 0.7548776662466927 + 0.5) % 1.0)
    angle = 2.0 * np.pi * ((number[:, 0] * 0.5698402909980532) % 1.0)
    turns = np.zeros((count, 3, 3), np.float32)
    turns[:, 0, 0] = turns[:, 1, 1] = np.cos(angle)
    turns[:, 1, 0] = np.sin(angle)
    turns[:, 0, 1] = -turns[:, 1, 0]
    turns[:, 2, 2] = 1.0
    return rays @ turns


def aisle_places(aisle: tuple[float, float, float, float]) -> Float[np.ndarray, "n 3"]:
    """Return places (m) all over an aisle, at the heights that cameras and goods have.

    Args:
        aisle: As ``SceneSpec.aisle``.
    """
    across = []
    for low, high in (aisle[:2], aisle[2:]):
        count = max(round((high - low) / _PITCH), 1)
        across.append(low + (np.arange(count) + 0.5) / count * (high - low))
    return np.stack(np.meshgrid(*across, _HEIGHTS, indexing="ij"), axis=-1).reshape(-1, 3)


def _eye_points(scene: SceneSpec, solid: CoarseScene) -> Float[np.ndarray, "n 3"]:
    """Return places (m) where cameras may stand: in the aisle, or around targets in a scene that knows no aisle."""
    if scene.aisle is not None:
        return aisle_places(scene.aisle)
    targets = scene.target_instances()
    turn = 2.0 * np.pi * np.arange(_SIDES) / _SIDES
    ring = np.stack([_AROUND * np.cos(turn), _AROUND * np.sin(turn), np.full(_SIDES, _ABOVE)], axis=1)
    to_eye = np.tile(ring, (len(targets), 1))
    target = np.array([item.T_world_object[:3, 3] for item in targets]).reshape(-1, 3).repeat(_SIDES, axis=0)
    size = np.array([np.linalg.norm(scene.model_of(item).size) for item in targets]).repeat(_SIDES)
    # Nothing may stand between: not behind a wall, and not in what stands next to the target.
    way = solid.cast(target + to_eye, -to_eye).distance
    return (target + to_eye)[(1.0 - way) * np.linalg.norm(ring[0]) < size / 2]


def _seen_from(eyes: Float[np.ndarray, "n 3"], solid: CoarseScene) -> Float[np.ndarray, "n j 3"]:
    """Return the ways (m) from eyes to what is seen in all directions; endless where nothing is."""
    look = sphere_directions(_EYE_RAYS)
    distance = solid.cast(np.repeat(eyes, _EYE_RAYS, axis=0), np.tile(look, (len(eyes), 1))).distance
    with np.errstate(invalid="ignore"):
        return distance.reshape(-1, _EYE_RAYS)[..., None] * look


_Frame = tuple[np.ndarray, np.ndarray, tuple[int, int, int], np.ndarray]
"""First point and spacing (m) of a grid, its numbers of points along the axes, on which sides it is cut."""


def _extent(
    eyes: Float[np.ndarray, "n 3"], seen: Float[np.ndarray, "n j 3"], solid: CoarseScene, number: int
) -> _Frame:
    """Return the frame of a level's grid around what is seen from eyes, as far as the level reaches."""
    # Down to what is lowest and no further: nothing that is seen from below may shine through the floor.
    low, high, cut = solid.low - _BESIDE * [1, 1, 0], solid.high + _BESIDE, np.zeros((2, 3), bool)
    if len(eyes):
        length = np.linalg.norm(seen, axis=2)
        far = length > _FARTHEST[number]
        ends = eyes[:, None] + np.minimum(length, _FARTHEST[number])[..., None] * sphere_directions(_EYE_RAYS)
        low[:2], high = np.maximum(low, ends.min(axis=(0, 1)))[:2], np.minimum(high, ends.max(axis=(0, 1)))
        if far.any():
            near = ends[~far] if not far.all() else eyes
            cut = np.stack([ends[far].min(axis=0) < near.min(axis=0), ends[far].max(axis=0) > near.max(axis=0)])
        cut[0, 2] = False
    extent = np.maximum(high - low, _SPACING[number])
    step = max(float(np.prod(extent) / _POINTS[number]) ** (1 / 3), _SPACING[number])
    cells = np.maximum(np.ceil(extent / step).astype(int), 1)
    spacing = extent / cells
    # Half a cell inside: no point lies in the surfaces that bound the scene.
    return low + spacing / 2, spacing, (int(cells[0]), int(cells[1]), int(cells[2])), cut


def _points_of(origin: np.ndarray, spacing: np.ndarray, shape: tuple[int, int, int]) -> Float32[np.ndarray, "x y z 3"]:
    """Return the points (m) of a grid."""
    steps = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1)
    return (origin + steps * spacing).astype(np.float32)


def _trusted(
    frame: _Frame, ways: tuple[np.ndarray, np.ndarray, np.ndarray], outside: np.ndarray, eyes: Float[np.ndarray, "n 3"]
) -> Bool[np.ndarray, "nx ny nz"]:
    """Return the points that lie outside of things and are joined to those where cameras may stand."""
    origin, spacing, shape, _ = frame
    in_sight = np.zeros(shape, bool)
    cells = np.rint((eyes - origin) / spacing).astype(int)
    in_sight[tuple(np.clip(cells, 0, np.array(shape) - 1).T)] = True
    in_sight &= outside
    return outside & _reached(ways, in_sight) if in_sight.any() else outside


def _nearest_points(
    levels: list[GridLevel], places: Float32[np.ndarray, "n 3"], normals: Float32[np.ndarray, "n 3"]
) -> Int[np.ndarray, " n"]:
    """Return the point of the finest grid around each place (m) that lies best before the surface there."""
    found = np.zeros(len(places), int)
    for level in reversed(levels):
        # Three quarters of a cell off the surface: the nearest point is then never behind it.
        cells = level.cells(places + normals * (0.75 * level.spacing).astype(np.float32))
        last = np.array(level.shape) - 1
        within = np.ones(len(places), bool)
        if level is not levels[-1]:
            within &= ((cells >= 0) & (cells <= last)).all(axis=1)
        numbers = np.ravel_multi_index(tuple(np.clip(cells[within], 0, last).T), level.shape)
        found[within] = level.first + numbers
    return found


def _open_ways(
    solid: CoarseScene, points: Float32[np.ndarray, "nx ny nz 3"]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return which neighbours along each axis nothing stands between."""
    ways = []
    for axis in range(3):
        a, b = np.delete(points, -1, axis), np.delete(points, 0, axis)
        blocked = solid.blocked(a.reshape(-1, 3), (b - a).reshape(-1, 3))
        ways.append(~blocked.reshape(a.shape[:3]))
    return ways[0], ways[1], ways[2]


def neighbours(axis: int) -> tuple[tuple[slice, ...], tuple[slice, ...]]:
    """Return the indices of all points of a grid but the last along ``axis``, and of all but the first."""
    near, far = [slice(None)] * 3, [slice(None)] * 3
    near[axis], far[axis] = slice(None, -1), slice(1, None)
    return tuple(near), tuple(far)


def _reached(
    ways: tuple[np.ndarray, np.ndarray, np.ndarray], start: Bool[np.ndarray, "nx ny nz"]
) -> Bool[np.ndarray, "nx ny nz"]:
    """Return the points that a chain of open ways joins to ``start``.

    Others are behind the walls, or inside of cartons: their light must not shine through.
    """
    reached, count = start.copy(), 0
    while int(reached.sum()) > count:
        count = int(reached.sum())
        for axis, way in enumerate(ways):
            near, far = neighbours(axis)
            reached[far] |= reached[near] & way
            reached[near] |= reached[far] & way
    return reached
