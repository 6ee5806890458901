"""Amodal masks through a lens: looked up pixel by pixel in those of the pinhole, and exact along their outlines."""

import cv2
import numpy as np
from jaxtyping import Bool, Float, Int

from warehouse_sim.geometry.boxes import mask_box_xyxy
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.lens.edges import EdgeCaster
from warehouse_sim.render.lens.source import CANVAS_STEP, LensMap
from warehouse_sim.render.renderer import NOTHING_COVERED, AmodalMask
from warehouse_sim.schema import ObjectInstance

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
