"""The one traversal of the scene: instance ids, surface attributes and depth of the nearest surface of each pixel."""

from collections.abc import Sequence

import moderngl
import numpy as np

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.view_pyramid import ViewPyramid
from warehouse_sim.render.raster.context import clear_to_zero, float_depth_texture
from warehouse_sim.render.raster.materials import MaterialTable
from warehouse_sim.render.raster.mesh_batch import MeshBatch
from warehouse_sim.render.raster.mesh_levels import choose_levels
from warehouse_sim.render.raster.parts import PartTable
from warehouse_sim.render.raster.programs import source
from warehouse_sim.render.raster.projection import NEAR, WINDOW_PX, image_origin, window_intrinsics, window_viewport


class GeometryBuffer:
    """Render targets of one image size; what a pixel shows is stored, not yet how bright it is."""

    def __init__(self, context: moderngl.Context, size: tuple[int, int]) -> None:
        self.size = size
        self.instance_ids = context.texture(size, 1, dtype="i4")
        self.surface = context.texture(size, 2, dtype="u4")
        self.reach = context.texture(size, 4)
        self.depth = float_depth_texture(context, size)
        self.depth.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self.depth.compare_func = ""
        for texture in (self.instance_ids, self.surface, self.reach):
            texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self.target = context.framebuffer([self.instance_ids, self.surface, self.reach], self.depth)
        self.target.viewport = window_viewport(size)

    def begin(self) -> None:
        """Bind and clear: no instance, infinitely far."""
        self.target.use()
        clear_to_zero(None, "f")
        clear_to_zero(0, "i")
        clear_to_zero(1, "ui")
        clear_to_zero(2, "f")

    def release(self) -> None:
        """Free the device memory."""
        for item in (self.target, self.instance_ids, self.surface, self.reach, self.depth):
            item.release()


class GeometryPass:
    """Draws a part table into a geometry buffer."""

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._program = context.program(
            vertex_shader=source("place.glsl", "pack.glsl", "box_projection.glsl", "gbuffer.vert"),
            fragment_shader=source("pack.glsl", "gbuffer.frag"),
        )
        self._program["near"] = NEAR
        self._program["window"] = (WINDOW_PX, WINDOW_PX)

    def draw(
        self,
        target: GeometryBuffer,
        camera: PinholeCamera,
        table: PartTable,
        records: np.ndarray,
        batches: Sequence[MeshBatch],
        materials: MaterialTable,
    ) -> None:
        """Draw all solid parts in view, the nearest first so that hidden ones cost only their depth test.

        Args:
            target: Where to draw; its size is the camera's.
            camera: Intrinsics.
            table: The scene.
            records: The table placed in the camera frame.
            batches: One for each mesh of the table.
            materials: Supplies the texture scale.
        """
        target.begin()
        self._context.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self._context.depth_func = ">"  # reversed depth: nearer is larger
        self._context.front_face = "cw"  # the window's first row is the image's top row, which mirrors the faces
        self._context.cull_face = "back"
        self._program["intrinsics"] = window_intrinsics(camera)
        self._program["origin"] = image_origin(target.size)
        materials.values.use(0)
        self._program["materials"] = 0
        centre, half_edges = table.centres(records), records["rotation"] * table.half_size[..., None]
        seen = ViewPyramid.of(camera).touches_boxes(centre, half_edges, NEAR) & ~table.film
        levels = choose_levels(table, [batch.errors for batch in batches], records, camera)
        # The far end orders better than the centre: a floor reaches under everything and should come last.
        far_end = centre[:, 2] + np.abs(half_edges[..., 2]).sum(axis=1)
        for rows, batch in zip(table.rows_of_mesh, batches, strict=True):
            chosen = np.flatnonzero(seen[rows]) + rows.start
            chosen = chosen[np.argsort(far_end[chosen], kind="stable")]
            batch.draw_levels(self._program, records[chosen], levels[chosen])

    def release(self) -> None:
        """Free the device memory."""
        self._program.release()
