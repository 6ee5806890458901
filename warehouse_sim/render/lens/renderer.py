"""Any backend behind a lens: a wider view is rendered and resampled."""

from collections.abc import Sequence
from functools import partial

import cv2
import numpy as np
from jaxtyping import Float32, Int32, UInt8

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.lens.amodal_mask import amodal_mask_through_lens
from warehouse_sim.render.lens.edges import EdgeCaster, rough_pixels
from warehouse_sim.render.lens.source import LensMap, lens_map
from warehouse_sim.render.renderer import (
    AmodalMask,
    Capabilities,
    ClosingRenderer,
    Renderer,
    loaded,
    render_without_color,
)
from warehouse_sim.schema import ObjectInstance, RenderBuffers, SceneChange, SceneSpec


def through_lens(sampled: RenderBuffers, lens: LensMap, edges: EdgeCaster, T_world_camera: Transform) -> RenderBuffers:
    """Return what the camera shows of what its pinhole shows.

    Colours are filtered. Ids and normals are those of the nearest pixel, depth is that of its surface under the pixel's
    own ray; beside edges all three come from that ray itself.

    Args:
        sampled: The pinhole's buffers.
        lens: The camera's map.
        edges: Rays in the scene that was rendered.
        T_world_camera: Pose of the camera.
    """
    inverse = np.divide(np.float32(1.0), sampled.depth, out=np.zeros_like(sampled.depth), where=sampled.depth > 0)
    shown = RenderBuffers(
        rgb=_colors(sampled.rgb, lens) if sampled.rgb.size else sampled.rgb,
        depth=_depth(inverse, lens),
        instance_mask=np.take(sampled.instance_mask, lens.nearest),
        normals=None if sampled.normals is None else sampled.normals.reshape(-1, 3)[lens.nearest],
    )
    edges.refine(shown, np.take(rough_pixels(inverse, sampled.instance_mask), lens.nearest), lens, T_world_camera)
    return shown


def _colors(rgb: UInt8[np.ndarray, "sh sw 3"], lens: LensMap) -> UInt8[np.ndarray, "h w 3"]:
    """Return cubic taps and their mean, in the image's own values."""
    shown = [
        cv2.remap(rgb, coarse, fine, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE) for coarse, fine in lens.taps
    ]
    if len(shown) == 1:
        return shown[0]
    total = np.zeros(shown[0].shape, np.uint16)
    for item in shown:
        total += item
    return cv2.convertScaleAbs(total, alpha=1.0 / len(shown))


def _depth(inverse: Float32[np.ndarray, "sh sw"], lens: LensMap) -> Float32[np.ndarray, "h w"]:
    """Return the depth (m) where each pixel's ray meets the surface of the nearest source pixel.

    1 / z is linear over the image of a plane (perspective): its slope at a pixel tells its value beside the centre,
    exactly on planes.
    """
    beside = np.take(inverse, lens.nearest)
    seen = beside > 0
    for axis, order in ((0, (1, 0)), (1, (0, 1))):
        slope = cv2.Sobel(inverse, cv2.CV_32F, *order, ksize=1, scale=0.5)
        beside += np.take(slope, lens.nearest) * lens.off_centre[..., axis]
    return np.divide(np.float32(1.0), beside, out=np.zeros_like(beside), where=seen & (beside > 0))


class LensRenderer(ClosingRenderer):
    """Draws cameras with a lens by way of a pinhole that another renderer draws; those without are passed on.

    Args:
        renderer: The renderer; closing this closes it.
    """

    def __init__(self, renderer: Renderer) -> None:
        self._renderer = renderer
        self._scene: SceneSpec | None = None
        self._edges: EdgeCaster | None = None
        self._seen: tuple[PinholeCamera, bytes, Int32[np.ndarray, "h w"]] | None = None

    @property
    def description(self) -> str:
        """Name and version of the renderer."""
        return self._renderer.description

    @property
    def capabilities(self) -> Capabilities:
        """Those of what draws."""
        return self._renderer.capabilities

    def load(self, scene: SceneSpec) -> None:
        """Make ``scene`` the one that is rendered."""
        self._renderer.load(scene)
        change = SceneChange.between(self._scene, scene)
        if change.objects or change.surfaces:
            self._edges = self._seen = None
        self._scene = scene

    def render(
        self, camera: PinholeCamera, T_world_camera: Transform, normals: bool = False, color: bool = True
    ) -> RenderBuffers:
        """Render the loaded scene."""
        render = self._renderer.render if color else partial(render_without_color, self._renderer)
        if camera.distortion is None:
            return render(camera, T_world_camera, normals)
        lens = lens_map(camera)
        sampled = render(lens.source, T_world_camera, normals)
        shown = through_lens(sampled, lens, self._edge_caster(), T_world_camera)
        self._seen = camera, T_world_camera.tobytes(), shown.instance_mask
        return shown

    def amodal_masks(
        self, camera: PinholeCamera, T_world_camera: Transform, instances: Sequence[ObjectInstance]
    ) -> list[AmodalMask]:
        """Return the unoccluded amodal mask of each of ``instances``; it holds all pixels that show the object."""
        if camera.distortion is None:
            return self._renderer.amodal_masks(camera, T_world_camera, instances)
        lens = lens_map(camera)
        sampled = self._renderer.amodal_masks(lens.source, T_world_camera, instances)
        instance_mask = self._instance_mask_of(camera, T_world_camera)
        return [
            amodal_mask_through_lens(
                amodal_mask,
                lens,
                self._edge_caster(),
                T_world_camera,
                item,
                instance_mask == item.instance_id,
            )
            for amodal_mask, item in zip(sampled, instances, strict=True)
        ]

    def close(self) -> None:
        """Close the renderer."""
        self._renderer.close()

    def _edge_caster(self) -> EdgeCaster:
        if self._edges is None:
            self._edges = EdgeCaster(loaded(self._scene))
        return self._edges

    def _instance_mask_of(self, camera: PinholeCamera, T_world_camera: Transform) -> Int32[np.ndarray, "h w"]:
        """Return the instance mask of a view; it is rendered unless it was the last one that was."""
        if self._seen is None or self._seen[:2] != (camera, T_world_camera.tobytes()):
            return self.render(camera, T_world_camera).instance_mask
        return self._seen[2]
