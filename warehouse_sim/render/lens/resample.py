"""From the pinhole's buffers to those behind the lens, each kind in the way that keeps it true."""

import cv2
import numpy as np
from jaxtyping import Float32, UInt8

from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.lens.edges import EdgeCaster, rough_pixels
from warehouse_sim.render.lens.source import LensMap
from warehouse_sim.schema import RenderBuffers


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
        rgb=_colors(sampled.rgb, lens),
        depth=_depth(inverse, lens),
        instance_ids=np.take(sampled.instance_ids, lens.nearest),
        normals=None if sampled.normals is None else sampled.normals.reshape(-1, 3)[lens.nearest],
    )
    edges.refine(shown, np.take(rough_pixels(inverse, sampled.instance_ids), lens.nearest), lens, T_world_camera)
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
