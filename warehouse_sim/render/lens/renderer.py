"""Any backend behind a lens: a wider view is rendered and resampled, and so are amodal masks."""

from collections.abc import Sequence
from functools import partial

import cv2
import numpy as np
from jaxtyping import Bool, Float, Float32, Int, Int32, UInt8

from warehouse_sim.geometry.boxes import mask_box_xyxy
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.lens.edges import EdgeCaster, rough_pixels
from warehouse_sim.render.lens.source import CANVAS_STEP, LensMap, lens_map
from warehouse_sim.render.renderer import (
    NOTHING_COVERED,
    AmodalMask,
    Capabilities,
    ClosingRenderer,
    Renderer,
    loaded,
    render_without_color,
)
from warehouse_sim.schema import ObjectInstance, RenderBuffers, SceneChange, SceneSpec

_MARGIN_PX = 4


def amodal_mask_through_lens(
    sampled: AmodalMask,
    lens: LensMap,
    edges: EdgeCaster,
    T_world_camera: Transform,
    item: ObjectInstance,
    visible: Bool[np.ndarray, "h w"],
) -> AmodalMask:
    """Return the amodal mask that the camera shows, on the canvas of 3 x 3 images.

    Inside it is looked up in the pinhole's, along its outline by rays through the pixels at the object alone.

    Args:
        sampled: The pinhole's amodal mask.
        lens: The camera's map.
        edges: Rays in the scene that was rendered.
        T_world_camera: Pose of the camera.
        item: The object.
        visible: Pixels of the image that show it; the amodal mask holds them all, whatever a sliver of the object does
            between the pixels of the pinhole.
    """
    box = mask_box_xyxy(visible)
    window = _window(sampled, lens, box)
    if window is None:
        return NOTHING_COVERED
    left, top, right, bottom = window
    mask = _looked_up(sampled, _source_pixels(lens, left, top, right, bottom))
    edges.outline(mask, (left, top), lens, T_world_camera, item)
    if box is not None:
        first_column, first_row, last_column, last_row = box
        inside = mask[first_row - top : last_row + 1 - top, first_column - left : last_column + 1 - left]
        inside |= visible[first_row : last_row + 1, first_column : last_column + 1]
    return AmodalMask.of(mask, left, top)


def _looked_up(sampled: AmodalMask, pixels: Int[np.ndarray, "h w 2"]) -> Bool[np.ndarray, "h w"]:
    """Return which source pixels are in an amodal mask."""
    height, width = sampled.mask.shape
    if not sampled.mask.size:
        return np.zeros(pixels.shape[:2], bool)
    columns, rows = np.moveaxis(pixels - np.array(sampled.offset), -1, 0)
    inside = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
    mask: Bool[np.ndarray, "h w"] = inside & sampled.mask[np.clip(rows, 0, height - 1), np.clip(columns, 0, width - 1)]
    return mask


def _window(
    sampled: AmodalMask, lens: LensMap, box: tuple[int, int, int, int] | None
) -> tuple[int, int, int, int] | None:
    """Return first column and row, and those after the last, of the part of the canvas around an amodal mask and a box.

    Args:
        sampled: The pinhole's amodal mask; its outline encloses it behind the lens, too.
        lens: The camera's map.
        box: First and last column and row of what else must fit, or None.
    """
    places = [] if box is None else [np.array(box, float).reshape(2, 2)]
    if sampled.mask.size:
        pixels = sampled.mask.astype(np.uint8)
        kept = cv2.erode(pixels, np.ones((3, 3), np.uint8), borderType=cv2.BORDER_CONSTANT, borderValue=0)
        rows, columns = np.nonzero(pixels != kept)
        rays = lens.source.rays_at(columns + sampled.offset[0], rows + sampled.offset[1])
        places.append(lens.camera.project(rays))
    if not places:
        return None
    found, size = np.concatenate(places), np.array([lens.camera.width, lens.camera.height])
    left, top = np.maximum(np.floor(found.min(axis=0)) - _MARGIN_PX, -size).astype(int).tolist()
    right, bottom = np.minimum(np.ceil(found.max(axis=0)) + _MARGIN_PX + 1, 2 * size).astype(int).tolist()
    return (left, top, right, bottom) if left < right and top < bottom else None


def _source_pixels(lens: LensMap, left: int, top: int, right: int, bottom: int) -> Int[np.ndarray, "h w 2"]:
    """Return column and row of the source pixel for each pixel of a window: exact in the image, else interpolated."""
    width, height = lens.camera.width, lens.camera.height
    inner_left, inner_right = max(left, 0), min(right, width)
    inner_top, inner_bottom = max(top, 0), min(bottom, height)
    if (inner_left, inner_top, inner_right, inner_bottom) == (left, top, right, bottom):
        return lens.pixels[top:bottom, left:right]
    pixels = np.floor(_interpolated(lens, left, top, right, bottom) + 0.5).astype(np.int32)
    if inner_left < inner_right and inner_top < inner_bottom:
        pixels[inner_top - top : inner_bottom - top, inner_left - left : inner_right - left] = lens.pixels[
            inner_top:inner_bottom, inner_left:inner_right
        ]
    return pixels


def _interpolated(lens: LensMap, left: int, top: int, right: int, bottom: int) -> Float[np.ndarray, "h w 2"]:
    """Return places in the source of the pixels of a window of the canvas."""
    u = ((np.arange(left, right) + lens.camera.width) / CANVAS_STEP).astype(np.float32)
    v = ((np.arange(top, bottom) + lens.camera.height) / CANVAS_STEP).astype(np.float32)
    return cv2.remap(lens.canvas, *np.meshgrid(u, v), cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)


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
