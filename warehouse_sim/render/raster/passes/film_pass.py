"""Stretch film and other surfaces of opacity below 1, blended over the shaded image.

Film is transparent to all but the colour: it writes neither depth nor instance ids, has no amodal mask and casts no
shadow, so that labels speak of the goods behind it. It is hidden by what stands before it.
"""

from collections.abc import Sequence

import moderngl
import numpy as np

from warehouse_sim.geometry.camera import PinholeCamera, ViewPyramid
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.raster.context import assign, source
from warehouse_sim.render.raster.light.lighting import UNITS, LightBlock, Lighting, Variant
from warehouse_sim.render.raster.meshes.mesh_batch import MeshBatch
from warehouse_sim.render.raster.meshes.parts import PartTable
from warehouse_sim.render.raster.passes.hidden_parts import DepthPyramid
from warehouse_sim.render.raster.projection import NEAR, WINDOW_PX, image_origin, window_intrinsics


class FilmPass:
    """Draws film parts from the farthest to the nearest."""

    def __init__(self, context: moderngl.Context, block: LightBlock) -> None:
        self._context, self._block = context, block
        self._programs: dict[Variant, moderngl.Program] = {}

    def draw(
        self,
        target: moderngl.Framebuffer,
        depth: moderngl.Texture,
        camera: PinholeCamera,
        T_world_camera: Transform,
        table: PartTable,
        records: np.ndarray,
        batches: Sequence[MeshBatch],
        lighting: Lighting,
    ) -> None:
        """Blend all film in view over ``target``.

        Args:
            target: The image, with the depth of the solid surfaces.
            depth: That depth.
            camera: Intrinsics; the target's size is the camera's.
            T_world_camera: Pose of the camera.
            table: The scene.
            records: The table placed in the camera frame.
            batches: One for each mesh of the table.
            lighting: Lights, materials and exposure.
        """
        centre = table.centres(records)
        rows = np.flatnonzero(table.film & ViewPyramid.of(camera).touches(centre, table.radius, NEAR))
        if len(rows) > 0:
            sampled = DepthPyramid.read(depth, (camera.width, camera.height))
            rows = rows[~sampled.hides(camera, table, records, rows)]
        if len(rows) == 0:
            return
        program = self._program_for(lighting)
        self._block.bind(lighting, T_world_camera)
        assign(
            program,
            intrinsics=window_intrinsics(camera),
            origin=image_origin((camera.width, camera.height)),
            pixel=1.0 / camera.fx,
            **lighting.uniforms(T_world_camera),
        )
        target.use()
        self._context.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE | moderngl.BLEND)
        self._context.depth_func, self._context.front_face, self._context.cull_face = ">", "cw", "back"
        # Colours come multiplied by their cover; the target's alpha tells faces apart and stays as it is.
        separate = (moderngl.ONE, moderngl.ONE_MINUS_SRC_ALPHA, moderngl.ZERO, moderngl.ONE)
        self._context.blend_func = separate  # type: ignore[assignment]  # moderngl's stub knows pairs only
        far_first = rows[np.argsort(-np.linalg.norm(centre[rows], axis=1), kind="stable")]
        for mesh, run in table.runs(far_first):
            batches[mesh].draw(program, records[run])

    def _program_for(self, lighting: Lighting) -> moderngl.Program:
        """Return the program for this many lights and shadows, compiled when first requested."""
        if lighting.variant not in self._programs:
            constants = lighting.constants()
            program = self._context.program(
                vertex_shader=source("place.glsl", "box_projection.glsl", "field.glsl", "film.vert", **constants),
                fragment_shader=source("lights.glsl", "lighting.glsl", "film.frag", **constants),
            )
            assign(program, near=NEAR, window=(WINDOW_PX, WINDOW_PX), **UNITS)
            self._programs[lighting.variant] = program
        return self._programs[lighting.variant]
