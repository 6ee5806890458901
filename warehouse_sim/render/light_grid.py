"""A grid of points in a scene and all that rays from them hit: the geometry of light from the surroundings.

Rays meet a coarse copy of the scene: small curved parts are boxes, tiny ones are left out.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Float32, Int

from warehouse_sim.catalog.building.outdoors import OUTDOORS
from warehouse_sim.geometry.mesh import TriangleMesh, unit_box
from warehouse_sim.render.embree import PlacedMeshes
from warehouse_sim.schema import Part, SceneSpec

RAYS = 80
"""Rays from each point."""
_POINTS = 2200  # of the grid, about
_SPACING = 0.6  # least distance between two (m)
_FARTHEST = 7.0  # metres from where cameras may stand that the grid reaches
_PITCH = 2.0  # metres between the places that stand for an aisle, about
_HEIGHTS = (0.7, 2.0, 3.3)  # metres above its floor
_EYE_RAYS = 200  # directions from each such place that tell what can be seen
_AROUND, _ABOVE = 3.0, 1.0  # metres beside and over a target from where it may be looked at
_SIDES = 8  # of a target
_BESIDE = np.array([0.7, 0.7, 0.7])  # metres beside and above a scene smaller than that
_LIFT = 2e-3  # metres by which points on surfaces are lifted off them
_SOLID = 0.25  # share of rays that meet the inner side of a face from which on a point lies in something
_TINY = 0.15
"""Parts that fit into a ball of this radius (m) turn no light that matters."""
_SMALL = 0.75
"""Parts that fit into a ball of this radius (m) are taken for their bounding box if they have many faces."""
_MANY_FACES = 64


@dataclass(frozen=True, eq=False)
class CoarseHits:
    """Where rays end; rows of rays that leave the scene hold an infinite distance and zeros."""

    distance: Float32[np.ndarray, " n"]
    """In units of the ray's direction."""
    normals: Float32[np.ndarray, "n 3"]
    """Unit outward normals in the world."""
    albedo: Float32[np.ndarray, "n 3"]
    """Share of light that is returned, linear RGB."""


class CoarseScene:
    """What turns light in a scene, in an acceleration structure of its own.

    Args:
        scene: The scene; film and the glow of luminaires are left out.

    Raises:
        MissingPackageError: Embree is not installed.
    """

    def __init__(self, scene: SceneSpec) -> None:
        mesh, albedo = _coarse_mesh(scene)
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
class LightGrid:
    """Points, the rays that leave them, and the surfaces that the rays hit from outside."""

    solid: CoarseScene
    origin: Float[np.ndarray, "3"]
    """First point in the world (m)."""
    spacing: Float[np.ndarray, "3"]
    """Distance between points along each axis (m)."""
    shape: tuple[int, int, int]
    """Number of points along each axis."""
    rays: Float32[np.ndarray, "p j 3"]
    """Directions from each point; the same turned about z, so that neighbours do not miss the same things."""
    ways: tuple[np.ndarray, np.ndarray, np.ndarray]
    """Along each axis, one shorter there: whether neighbours see each other."""
    trusted: Bool[np.ndarray, "nx ny nz"]
    """Which points lie in the open, and in sight of a place to look from, of a point that does, and so on."""
    escaped: Bool[np.ndarray, "p j"]
    """Which rays leave the scene."""
    hit: Int[np.ndarray, " n"]
    """Which rays hit a surface: number of the point times ``RAYS`` plus that of the direction."""
    places: Float32[np.ndarray, "n 3"]
    """Where, lifted a little (m)."""
    normals: Float32[np.ndarray, "n 3"]
    albedo: Float32[np.ndarray, "n 3"]
    nearest: Int[np.ndarray, " n"]
    """The grid's point that lies best before each surface."""


def lay_grid(scene: SceneSpec) -> LightGrid:
    """Cast the rays of ``scene``; where its viewpoints are does not matter.

    Raises:
        MissingPackageError: Embree is not installed.
    """
    solid = CoarseScene(scene)
    eyes = _eye_points(scene, solid)
    origin, spacing, shape = _extent(eyes, solid)
    points = origin + np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1).reshape(-1, 3) * spacing
    points = points.astype(np.float32)
    rays = sphere_directions(RAYS) @ _turns(len(points))
    hits = solid.cast(np.repeat(points, RAYS, axis=0), rays.reshape(-1, 3))
    distance = hits.distance.reshape(-1, RAYS)
    inner = np.einsum("ijk,ijk->ij", hits.normals.reshape(-1, RAYS, 3), rays) > 0.0
    trusted = (inner.mean(axis=1) < _SOLID).reshape(shape)
    ways = _open_ways(solid, points.reshape(*shape, 3))
    in_sight = _nearest(eyes, origin, spacing, shape) & trusted
    if in_sight.any():
        trusted &= _reached(ways, in_sight)
    hit = np.flatnonzero(np.isfinite(distance) & ~inner)
    normals = hits.normals[hit]
    places = points[hit // RAYS] + rays.reshape(-1, 3)[hit] * hits.distance[hit, None] + normals * np.float32(_LIFT)
    # Three quarters of a cell off the surface: the nearest point is then never behind it.
    cell = np.rint((places + normals * spacing * 0.75 - origin) / spacing).astype(int)
    nearest = np.ravel_multi_index(tuple(np.clip(cell, 0, np.array(shape) - 1).T), shape)
    escaped = ~np.isfinite(distance)
    return LightGrid(
        solid, origin, spacing, shape, rays, ways, trusted, escaped, hit, places, normals,
        hits.albedo[hit], nearest,
    )  # fmt: skip


def sphere_directions(count: int) -> Float32[np.ndarray, "n 3"]:
    """Return ``count`` unit vectors spread evenly: the spherical Fibonacci lattice (Swinbank and Purser 2006)."""
    k = np.arange(count) + 0.5
    z, angle = 1.0 - 2.0 * k / count, np.pi * (1.0 + np.sqrt(5.0)) * k
    ring = np.sqrt(1.0 - z * z)
    return np.stack([ring * np.cos(angle), ring * np.sin(angle), z], axis=1).astype(np.float32)


def _turns(count: int) -> Float32[np.ndarray, "n 3 3"]:
    """Return rotations about z whose angles fill the circle evenly: multiples of the golden angle."""
    angle = np.arange(count) * np.pi * (3.0 - np.sqrt(5.0))
    turns = np.zeros((count, 3, 3), np.float32)
    turns[:, 0, 0] = turns[:, 1, 1] = np.cos(angle)
    turns[:, 1, 0] = np.sin(angle)
    turns[:, 0, 1] = -turns[:, 1, 0]
    turns[:, 2, 2] = 1.0
    return turns


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


def _extent(eyes: Float[np.ndarray, "n 3"], solid: CoarseScene) -> tuple[np.ndarray, np.ndarray, tuple[int, int, int]]:
    """Return first point, spacing (m) and numbers of points along the axes of a grid around what is seen from eyes."""
    # Down to what is lowest and no further: nothing that is seen from below may shine through the floor.
    low, high = solid.low - _BESIDE * [1, 1, 0], solid.high + _BESIDE
    if len(eyes):
        look = sphere_directions(_EYE_RAYS)
        distance = solid.cast(np.repeat(eyes, _EYE_RAYS, axis=0), np.tile(look, (len(eyes), 1))).distance
        way = np.minimum(distance.reshape(-1, _EYE_RAYS), _FARTHEST)[..., None] * look
        seen = (eyes[:, None] + way).reshape(-1, 3)
        low[:2], high = np.maximum(low, seen.min(axis=0))[:2], np.minimum(high, seen.max(axis=0))
    extent = np.maximum(high - low, _SPACING)
    step = max(float(np.prod(extent) / _POINTS) ** (1 / 3), _SPACING)
    cells = np.maximum(np.ceil(extent / step).astype(int), 1)
    spacing = extent / cells
    # Half a cell inside: no point lies in the surfaces that bound the scene.
    return low + spacing / 2, spacing, (int(cells[0]), int(cells[1]), int(cells[2]))


def _nearest(
    places: Float[np.ndarray, "n 3"], origin: np.ndarray, spacing: np.ndarray, shape: tuple[int, int, int]
) -> Bool[np.ndarray, "nx ny nz"]:
    """Return the points nearest to ``places``."""
    found = np.zeros(shape, bool)
    cells = np.rint((places - origin) / spacing).astype(int)
    found[tuple(np.clip(cells, 0, np.array(shape) - 1).T)] = True
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


def _coarse_mesh(scene: SceneSpec) -> tuple[TriangleMesh, Float[np.ndarray, "m 3"]]:
    """Return all that counts as one mesh in the world, and the albedo of each of its faces."""
    groups: dict[TriangleMesh, list[tuple[np.ndarray, Part]]] = {}
    for instance in scene.instances:
        if scene.model_of(instance).class_name == OUTDOORS:
            continue  # rays that leave the hall meet the even sky
        for part in scene.painted_model_of(instance).parts:
            if scene.materials[part.material].opacity >= 1.0:
                groups.setdefault(part.mesh, []).append((instance.T_world_object, part))
    vertices, faces, albedo, count = [np.zeros((0, 3))], [np.zeros((0, 3), np.int32)], [np.zeros((0, 3))], 0
    for mesh, members in groups.items():
        scale = np.stack([part.scale for _, part in members])
        low, high = mesh.vertices.min(axis=0) * scale, mesh.vertices.max(axis=0) * scale
        radius = np.linalg.norm(high - low, axis=1) / 2
        T = np.stack([T for T, _ in members]) @ np.stack([part.T_object_part for _, part in members])
        base = np.array([scene.materials[part.material].base_color for _, part in members])
        as_box = (radius < _SMALL) & (len(mesh.faces) > _MANY_FACES)
        box = (low + high)[:, None] / 2 + unit_box().vertices * (high - low)[:, None]
        for shape, local, chosen in (
            (unit_box(), box, as_box),
            (mesh, mesh.vertices * scale[:, None], ~as_box),
        ):
            rows = np.flatnonzero(chosen & (radius > _TINY))
            placed = np.einsum("nij,nkj->nki", T[rows, :3, :3], local[rows]) + T[rows, None, :3, 3]
            starts = count + len(shape.vertices) * np.arange(len(rows))
            vertices.append(placed.reshape(-1, 3))
            faces.append((shape.faces[None] + starts[:, None, None]).reshape(-1, 3).astype(np.int32))
            albedo.append(np.repeat(base[rows], len(shape.faces), axis=0))
            count += placed.shape[0] * placed.shape[1]
    return TriangleMesh(np.concatenate(vertices), np.concatenate(faces)), np.concatenate(albedo)
