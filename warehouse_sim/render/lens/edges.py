"""Pixels at edges: a nearest pixel is up to half a pixel wrong there, a ray through the pixel's own centre is not."""

from dataclasses import replace

import cv2
import numpy as np
from jaxtyping import Bool, Float32, Int32

from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.lens.source import LensMap
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import ObjectInstance, RenderBuffers, SceneSpec

_BENT = np.float32(0.002)
"""Second difference of 1 / z from pixel to pixel, relative to it, from which a surface ends or bends."""
_BAND_PX = 2
_SQUARE = np.ones((3, 3), np.uint8)


class EdgeCaster:
    """Exact rays where the renderer's pixels do not say enough.

    Args:
        scene: What is rendered.

    Raises:
        MissingPackageError: Embree is not installed.
    """

    def __init__(self, scene: SceneSpec) -> None:
        self._scene, self._all = scene, RayCaster(scene)
        self._alone: dict[int, RayCaster] = {}

    def refine(
        self, shown: RenderBuffers, rough: Bool[np.ndarray, "h w"], lens: LensMap, T_world_camera: Transform
    ) -> None:
        """Replace ids, depth and normals of the ``rough`` pixels in place by what rays through their centres meet."""
        rows, columns = np.nonzero(rough)
        rays = lens.camera.rays()[rows, columns]
        R, eye = T_world_camera[:3, :3], T_world_camera[:3, 3]
        hits = self._all.cast(np.broadcast_to(eye, rays.shape), rays @ R.T)
        shown.instance_mask[rows, columns] = hits.instance_ids
        # Rays have length 1 along the optical axis, so that distances are depths.
        shown.depth[rows, columns] = np.where(np.isfinite(hits.distance), hits.distance, 0.0)
        if shown.normals is not None:
            shown.normals[rows, columns] = hits.normals @ R

    def outline(
        self, mask: Bool[np.ndarray, "h w"], offset: tuple[int, int], lens: LensMap, T: Transform, item: ObjectInstance
    ) -> None:
        """Replace the pixels along the outline of an amodal mask in place by what rays at the object alone meet.

        Args:
            mask: Amodal mask, with a margin of at least two pixels.
            offset: Column and row in the image of its first pixel.
            lens: The camera's map.
            T: ``T_world_camera``.
            item: The object.
        """
        pixels = mask.astype(np.uint8)
        grown = cv2.dilate(pixels, _SQUARE, iterations=_BAND_PX)
        kept = cv2.erode(pixels, _SQUARE, iterations=_BAND_PX, borderType=cv2.BORDER_CONSTANT, borderValue=1)
        rows, columns = np.nonzero(grown != kept)
        rays = lens.camera.rays_at(columns + offset[0], rows + offset[1])
        if item.instance_id not in self._alone:
            self._alone[item.instance_id] = RayCaster(replace(self._scene, instances=(item,)))
        hits = self._alone[item.instance_id].cast(np.broadcast_to(T[:3, 3], rays.shape), rays @ T[:3, :3].T)
        mask[rows, columns] = hits.instance_ids == item.instance_id


def rough_pixels(
    inverse: Float32[np.ndarray, "sh sw"], instance_mask: Int32[np.ndarray, "sh sw"]
) -> Bool[np.ndarray, "sh sw"]:
    """Return the pixels of a pinhole's image beside which something ends, begins or bends.

    Args:
        inverse: 1 / z, 0 for nothing.
        instance_mask: Instance by pixel, 0 = background.
    """
    found = np.zeros(instance_mask.shape, np.uint8)
    for axis, order in ((0, (0, 2)), (1, (2, 0))):
        bend = np.abs(cv2.Sobel(inverse, cv2.CV_32F, *order, ksize=1)) > _BENT * inverse
        differ = np.diff(instance_mask, axis=axis) != 0
        bend[(slice(1, None), slice(None)) if axis == 0 else (slice(None), slice(1, None))] |= differ
        bend[(slice(None, -1), slice(None)) if axis == 0 else (slice(None), slice(None, -1))] |= differ
        found |= bend
    return cv2.dilate(found, _SQUARE).astype(bool)
