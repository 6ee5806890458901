"""One mesh on the graphics device with room for all its instances, drawn in one call."""

import moderngl
import numpy as np
from jaxtyping import Float32, Int32

from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.render.raster.parts import INSTANCE, INSTANCE_FORMAT

_ATTRIBUTES = ("in_position", "in_normal")
_INSTANCE_ATTRIBUTES = ("in_rotation", "in_translation", "in_scale", "in_texture_shift", "in_identity")


class MeshBatch:
    """Draws instances of one mesh with any program whose vertex shader includes ``place.glsl``."""

    def __init__(self, context: moderngl.Context, mesh: TriangleMesh, capacity: int) -> None:
        self._context = context
        vertices, indices = flat_shaded(mesh)
        self._vertices = context.buffer(vertices.tobytes())
        self._indices = context.buffer(indices.tobytes())
        self._instances = context.buffer(reserve=max(capacity, 1) * INSTANCE.itemsize, dynamic=True)
        self._arrays: dict[int, moderngl.VertexArray] = {}

    def draw(self, program: moderngl.Program, records: np.ndarray) -> None:
        """Draw one instance for each of ``records`` (dtype ``INSTANCE``) into the bound framebuffer."""
        if len(records) == 0:
            return
        if records.nbytes > self._instances.size:
            self._instances.orphan(records.nbytes)
        self._instances.write(records.tobytes())
        self._array(program).render(moderngl.TRIANGLES, instances=len(records))

    def release(self) -> None:
        """Free the device memory."""
        for array in self._arrays.values():
            array.release()
        for buffer in (self._vertices, self._indices, self._instances):
            buffer.release()

    def _array(self, program: moderngl.Program) -> moderngl.VertexArray:
        if program.glo not in self._arrays:
            content = [
                (self._vertices, *_used(program, "3f4 3f4", _ATTRIBUTES)),
                (self._instances, *_used(program, INSTANCE_FORMAT, _INSTANCE_ATTRIBUTES)),
            ]
            self._arrays[program.glo] = self._context.vertex_array(program, content, self._indices)
        return self._arrays[program.glo]


def flat_shaded(mesh: TriangleMesh) -> tuple[Float32[np.ndarray, "k 6"], Int32[np.ndarray, "m 3"]]:
    """Return vertices (position, face normal) that are split where neighbouring faces differ, and triangles of them."""
    normals = np.round(np.repeat(mesh.face_normals()[:, None], 3, axis=1), 6)
    corners = np.concatenate([mesh.vertices[mesh.faces], normals], axis=2).reshape(-1, 6).astype(np.float32)
    vertices, indices = np.unique(corners, axis=0, return_inverse=True)
    return vertices, indices.reshape(-1, 3).astype(np.int32)


def _used(program: moderngl.Program, layout: str, names: tuple[str, ...]) -> tuple[str, ...]:
    """Return ``layout`` with padding in place of the attributes that the compiler removed, and the names left."""
    layout, _, per_instance = layout.partition("/")
    fields = [(item, name, name in program) for item, name in zip(layout.split(), names, strict=True)]
    # Every component has four bytes; moderngl writes padding as "<bytes>x".
    kept = " ".join(item if used else f"{4 * int(item[0])}x" for item, _, used in fields)
    return (kept + ("/" + per_instance if per_instance else ""), *(name for _, name, used in fields if used))
