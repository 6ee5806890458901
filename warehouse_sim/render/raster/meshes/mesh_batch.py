"""One mesh on the graphics device with room for all its instances, drawn in one call a level of detail."""

from collections.abc import Callable, Sequence

import moderngl
import numpy as np
from jaxtyping import Int

from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.render.raster.meshes.mesh_levels import CORNER_FORMAT, FlatMesh, MeshLevels, mesh_levels
from warehouse_sim.render.raster.meshes.parts import INSTANCE, INSTANCE_FORMAT

_ATTRIBUTES = ("in_position", "in_normal", "in_to_edge")
_INSTANCE_ATTRIBUTES = ("in_rotation", "in_translation", "in_scale", "in_texture_shift", "in_identity", "in_picture")


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

    def release(self) -> None:
        """Free the device memory."""
        for level in self._levels:
            level.release()
        self._instances.release()


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
        for mesh in self._batches.keys() - set(meshes):
            self._batches.pop(mesh).release()
        return [self._batches[mesh] for mesh in meshes]

    def release(self) -> None:
        """Free the device memory."""
        self.require(())


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

    def release(self) -> None:
        for array in self._arrays.values():
            array.release()
        for buffer in (self._corners, self._triangles):
            buffer.release()


def _used(program: moderngl.Program, layout: str, names: tuple[str, ...]) -> tuple[str, ...]:
    """Return ``layout`` with padding in place of the attributes that the compiler removed, and the names left."""
    layout, _, per_instance = layout.partition("/")
    fields = [(item, name, name in program) for item, name in zip(layout.split(), names, strict=True)]
    # An item is a count, a kind and the bytes of a component; moderngl writes padding as "<bytes>x".
    kept = " ".join(item if used else f"{int(item[0]) * int(item[2])}x" for item, _, used in fields)
    return (kept + ("/" + per_instance if per_instance else ""), *(name for _, name, used in fields if used))
