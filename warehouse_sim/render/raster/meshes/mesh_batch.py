"""Meshes on the graphics device: their levels of detail, and room for all instances, drawn in one call a level."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import moderngl
import numpy as np
from jaxtyping import Bool, Float, Int, Int32, UInt8

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.detail_levels import Facets, detail_levels, facets
from warehouse_sim.geometry.mesh import TriangleMesh, equal_rows
from warehouse_sim.render.raster.meshes.parts import INSTANCE, INSTANCE_FORMAT, PartTable
from warehouse_sim.render.raster.projection import NEAR

CORNER = np.dtype([("position", "f4", 3), ("normal", "f4", 3), ("to_edge", "u1", 4)])
"""A vertex on the graphics device."""
CORNER_FORMAT = "3f4 3f4 4f1"
_NO_EDGE = 255


@dataclass(frozen=True, eq=False)
class FlatMesh:
    """Corners that are split where neighbouring faces differ, and the triangles between them."""

    corners: np.ndarray
    """(k,) of dtype ``CORNER``; ``to_edge`` holds four functions that are linear on a face, 0 on one of its edges and
    255 at the far side, or 255 everywhere where there is no such edge. What two coplanar triangles share is no edge."""
    triangles: Int32[np.ndarray, "m 3"]


def flat_mesh(mesh: TriangleMesh, known: Facets | None = None) -> FlatMesh:
    """Prepare ``mesh``; halves of a parallelogram become one face with four edges, which needs no more corners.

    Args:
        mesh: What is rendered.
        known: Its facets, where they are known.
    """
    found = facets(mesh) if known is None else known
    pair, turn = found.halves
    is_single = np.ones(len(found.faces), bool)
    is_single[pair] = False
    single = np.flatnonzero(is_single)
    quads = _quad_corners(mesh, found, pair, turn)
    barycentric = _barycentric(found.inner[single])
    lone = _corners(mesh.vertices[found.faces[single]], found.normals[single], barycentric)
    corners = np.concatenate([quads.ravel(), lone.ravel()])
    index = np.arange(4 * len(pair)).reshape(-1, 4)[:, [0, 1, 3, 1, 2, 3]].reshape(-1, 3)
    triangles = np.concatenate([index, 4 * len(pair) + np.arange(3 * len(single)).reshape(-1, 3)])
    first, number = equal_rows(corners)
    return FlatMesh(corners[first], number[triangles].astype(np.int32))


def _quad_corners(
    mesh: TriangleMesh, found: Facets, pair: Int[np.ndarray, "q 2"], turn: Int[np.ndarray, "q 2"]
) -> np.ndarray:
    """Return the corners (q, 4) of parallelograms, counter-clockwise from the first triangle's corner off the diagonal.

    Edges 0 to 3 follow that corner in this order; across a parallelogram opposite edges add up to one.
    """
    (first, second), (i, j) = pair.T, turn.T
    faces, inner = found.faces, found.inner
    ring = [faces[first, i], faces[first, (i + 1) % 3], faces[second, j], faces[first, (i + 2) % 3]]
    hidden = [
        inner[first, (i + 2) % 3],
        inner[second, (j + 1) % 3],
        inner[second, (j + 2) % 3],
        inner[first, (i + 1) % 3],
    ]
    values = np.array([[0, 0, 1, 1], [1, 0, 0, 1], [1, 1, 0, 0], [0, 1, 1, 0]], np.uint8).T * _NO_EDGE
    to_edge = np.where(np.stack(hidden, axis=1)[:, None], _NO_EDGE, values[None]).astype(np.uint8)
    return _corners(mesh.vertices[np.stack(ring, axis=1)], found.normals[first], to_edge)


def _barycentric(inner: Bool[np.ndarray, "m 3"]) -> UInt8[np.ndarray, "m 3 4"]:
    values = np.concatenate([np.eye(3, dtype=np.uint8) * _NO_EDGE, np.full((3, 1), _NO_EDGE, np.uint8)], axis=1)
    hidden = np.concatenate([inner, np.ones((len(inner), 1), bool)], axis=1)
    return np.where(hidden[:, None], _NO_EDGE, values[None]).astype(np.uint8)


def _corners(
    points: Float[np.ndarray, "n c 3"], normals: Float[np.ndarray, "n 3"], to_edge: UInt8[np.ndarray, "n c 4"]
) -> np.ndarray:
    corners = np.zeros(points.shape[:2], CORNER)
    corners["position"], corners["normal"], corners["to_edge"] = points, normals[:, None], to_edge
    return corners


LEVEL_ERROR_PX = 0.25
"""How far a coarser mesh may be from the true one in the image."""


@dataclass(frozen=True, eq=False)
class MeshLevels:
    """A mesh as the rasteriser reads it, at all its levels of detail."""

    flat: tuple[FlatMesh, ...]
    """The finest first."""
    errors: Float[np.ndarray, " l"]
    """Largest distance of each from the true surface, in the mesh's own units (m)."""


_known: WeakKeyDictionary[TriangleMesh, MeshLevels] = WeakKeyDictionary()


def mesh_levels(mesh: TriangleMesh) -> MeshLevels:
    """Return the levels of ``mesh``, made when first requested and kept as long as the mesh is."""
    if mesh not in _known:
        found = facets(mesh)
        finest, *coarser = detail_levels(mesh, found)
        flat = (flat_mesh(finest.mesh, found), *(flat_mesh(level.mesh) for level in coarser))
        _known[mesh] = MeshLevels(flat, np.array([finest.error, *(level.error for level in coarser)]))
    return _known[mesh]


def only_level(mesh: TriangleMesh) -> MeshLevels:
    """Return ``mesh`` as it is rendered at any distance."""
    return MeshLevels((flat_mesh(mesh),), np.zeros(1))


def choose_levels(
    table: PartTable, errors: Sequence[Float[np.ndarray, " l"]], records: np.ndarray, camera: PinholeCamera
) -> Int[np.ndarray, " n"]:
    """Return the coarsest level of each row of ``table`` whose error nobody sees; it depends on the row and view alone.

    Args:
        table: The parts.
        errors: For each mesh of the table, the errors of its levels.
        records: The table placed in the camera frame.
        camera: Intrinsics.
    """
    levels = np.zeros(len(table), int)
    detailed = [(rows, limits) for rows, limits in zip(table.rows_of_mesh, errors, strict=True) if len(limits) > 1]
    if not detailed:
        return levels
    # Along the axis only: an upright is tall, but all of it is about as far away.
    reach = (np.abs(records["rotation"][:, :, 2]) * table.half_size).sum(axis=1)
    nearest = np.maximum(table.centres(records)[:, 2] - reach, NEAR)
    # At the border of a wide image a shift along the axis is seen more than at its middle.
    across = max(camera.cx, camera.width - camera.cx) / camera.fx
    down = max(camera.cy, camera.height - camera.cy) / camera.fy
    pixels_per_metre = max(camera.fx, camera.fy) * np.sqrt(1.0 + across**2 + down**2) / nearest
    allowed = LEVEL_ERROR_PX / (pixels_per_metre * np.abs(table.template["scale"]).max(axis=1))
    for rows, limits in detailed:
        levels[rows] = np.searchsorted(limits, allowed[rows], side="right") - 1
    return levels


_ATTRIBUTES = ("in_position", "in_normal", "in_to_edge")
_INSTANCE_ATTRIBUTES = (
    *("in_rotation", "in_translation", "in_scale", "in_texture_shift"),
    *("in_identity", "in_spread", "in_start", "in_picture"),
)


class MeshBatch:
    """Draws instances of one mesh with any program whose vertex shader includes ``place.glsl``."""

    def __init__(self, context: moderngl.Context, levels: MeshLevels) -> None:
        self._context = context
        self.errors = levels.errors
        """Largest distance of each level from the true surface, in the mesh's own units (m); the finest first."""
        self.triangles = np.array([len(flat.triangles) for flat in levels.flat])
        """Of each level."""
        self._instances = context.buffer(reserve=INSTANCE.itemsize, dynamic=True)  # grows with what is rendered
        self._levels = [_Level(context, flat, self._instances) for flat in levels.flat]

    def draw(self, program: moderngl.Program, records: np.ndarray, level: int = 0) -> None:
        """Draw one instance for each of ``records`` (dtype ``INSTANCE``) into the bound framebuffer."""
        if len(records) == 0:
            return
        if records.nbytes > self._instances.size:
            self._instances.orphan(records.nbytes)
        self._instances.write(np.ascontiguousarray(records))
        self._levels[level].array(program).render(moderngl.TRIANGLES, instances=len(records))

    def draw_levels(self, program: moderngl.Program, records: np.ndarray, levels: Int[np.ndarray, " n"]) -> None:
        """Draw each of ``records`` at its level of ``levels``."""
        if len(self._levels) == 1:
            self.draw(program, records)
            return
        for level in range(len(self._levels)):
            self.draw(program, records[levels == level], level)


class MeshLibrary:
    """The batches of the meshes in use; scenes from one catalog share most of them.

    Args:
        context: Where to upload to.
        levels: Gives the levels of detail of a mesh.
    """

    def __init__(self, context: moderngl.Context, levels: Callable[[TriangleMesh], MeshLevels] = mesh_levels) -> None:
        self._context, self._levels = context, levels
        self._batches: dict[TriangleMesh, MeshBatch] = {}

    def require(self, meshes: Sequence[TriangleMesh]) -> list[MeshBatch]:
        """Return the batch of each of ``meshes``; those that are new are uploaded, all others freed."""
        for mesh in meshes:
            if mesh not in self._batches:
                self._batches[mesh] = MeshBatch(self._context, self._levels(mesh))
        self._batches = {mesh: self._batches[mesh] for mesh in meshes}
        return [self._batches[mesh] for mesh in meshes]


class _Level:
    """The corners and triangles of one level, and their binding to each program that draws them."""

    def __init__(self, context: moderngl.Context, flat: FlatMesh, instances: moderngl.Buffer) -> None:
        self._context, self._instances = context, instances
        self._corners = context.buffer(flat.corners.tobytes())
        self._triangles = context.buffer(flat.triangles.tobytes())
        self._arrays: dict[int, moderngl.VertexArray] = {}

    def array(self, program: moderngl.Program) -> moderngl.VertexArray:
        if program.glo not in self._arrays:
            content = [
                (self._corners, *_used(program, CORNER_FORMAT, _ATTRIBUTES)),
                (self._instances, *_used(program, INSTANCE_FORMAT, _INSTANCE_ATTRIBUTES)),
            ]
            self._arrays[program.glo] = self._context.vertex_array(program, content, self._triangles)
        return self._arrays[program.glo]


def _used(program: moderngl.Program, layout: str, names: tuple[str, ...]) -> tuple[str, ...]:
    """Return ``layout`` with padding in place of the attributes that the compiler removed, and the names left."""
    layout, _, per_instance = layout.partition("/")
    fields = [(item, name, name in program) for item, name in zip(layout.split(), names, strict=True)]
    # An item is a count, a kind and the bytes of a component; moderngl writes padding as "<bytes>x".
    kept = " ".join(item if used else f"{int(item[0]) * int(item[2])}x" for item, _, used in fields)
    return (kept + ("/" + per_instance if per_instance else ""), *(name for _, name, used in fields if used))
