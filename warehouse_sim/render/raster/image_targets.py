"""The images that a view is rendered into, and their way back to numpy."""

import cv2
import moderngl
import numpy as np

from warehouse_sim.render.raster.passes.antialias import EdgeSmoother
from warehouse_sim.render.raster.passes.geometry_pass import GeometryBuffer
from warehouse_sim.render.raster.projection import NEAR, window_viewport
from warehouse_sim.schema import RenderBuffers


class ImageTargets:
    """Geometry buffer, colour and normals of one image size."""

    def __init__(self, context: moderngl.Context, size: tuple[int, int]) -> None:
        self.size = size
        self._smoother = EdgeSmoother(size)
        self.geometry = GeometryBuffer(context, size)
        self._color_texture = context.texture(size, 4)
        self._normal_texture = context.texture(size, 4, dtype="f4")
        self.color = context.framebuffer([self._color_texture])
        self.normals = context.framebuffer([self._normal_texture])
        self.film = context.framebuffer([self._color_texture], self.geometry.depth)
        self.film.depth_mask = False
        self.film.viewport = window_viewport(size)

    def read(self, normals: bool) -> RenderBuffers:
        """Return what was rendered."""
        width, height = self.size
        rgba, instance_mask = np.empty((height, width, 4), np.uint8), np.empty((height, width), np.int32)
        stored = np.empty((height, width), np.float32)
        self._color_texture.read_into(rgba)
        self.geometry.instance_mask.read_into(instance_mask)
        self.geometry.depth.read_into(stored)
        reach = np.empty((height, width, 4), np.uint8)
        self.geometry.reach.read_into(reach)
        self._smoother.smooth(rgba, reach, stored)
        return RenderBuffers(
            rgb=cv2.cvtColor(rgba, cv2.COLOR_RGBA2RGB),
            depth=np.divide(np.float32(NEAR), stored, out=np.zeros_like(stored), where=stored > 0),
            instance_mask=instance_mask,
            normals=self._read_normals() if normals else None,
        )

    def release(self) -> None:
        """Free the device memory."""
        for item in (self.film, self.geometry, self.color, self.normals, self._color_texture, self._normal_texture):
            item.release()

    def _read_normals(self) -> np.ndarray:
        width, height = self.size
        values = np.empty((height, width, 4), np.float32)
        self._normal_texture.read_into(values)
        return np.ascontiguousarray(values[..., :3])
