"""A pair behind lenses is compared as real pipelines do it: rectified first, looked up by pixel afterwards."""

from functools import lru_cache

import cv2
import numpy as np
from jaxtyping import Bool, Float32, UInt8

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.render.lens import lens_map
from warehouse_sim.sensors.stereo.config import SgbmConfig
from warehouse_sim.sensors.stereo.disparity import match_sgbm, seen_in_both


def both_see(
    left: Float32[np.ndarray, "h w"], right: Float32[np.ndarray, "h w"], camera: PinholeCamera
) -> Bool[np.ndarray, "h w"]:
    """Return which pixels of the left image the right camera sees, too; see ``seen_in_both``.

    Args:
        left: f b / z in the left image (px), 0 = nothing there.
        right: f b / z in the right image (px), 0 = nothing there.
        camera: That of both images.
    """
    if camera.distortion is None:
        return seen_in_both(left, right)
    lens, place = lens_map(camera), _places(camera)
    finer = np.float32(lens.source.fx / camera.fx)
    straight = [cv2.remap(image * finer, place, None, cv2.INTER_NEAREST) for image in (left, right)]
    return np.take(seen_in_both(straight[0], straight[1]), lens.nearest)


def match(
    left: UInt8[np.ndarray, "h w 3"], right: UInt8[np.ndarray, "h w 3"], config: SgbmConfig, camera: PinholeCamera
) -> Float32[np.ndarray, "h w"]:
    """Return the disparity (px at the camera's focal length) of the left image by ``match_sgbm``, 0 = none.

    Args:
        left: Left image.
        right: Right image.
        config: The matcher.
        camera: That of both images.
    """
    if camera.distortion is None:
        return match_sgbm(left, right, config)
    lens, place = lens_map(camera), _places(camera)
    straight = [cv2.remap(image, place, None, cv2.INTER_LINEAR) for image in (left, right)]
    found = np.take(match_sgbm(straight[0], straight[1], config), lens.nearest)
    return found * np.float32(camera.fx / lens.source.fx)


@lru_cache(maxsize=2)
def _places(camera: PinholeCamera) -> Float32[np.ndarray, "sh sw 2"]:
    """Return where in the camera's image each pixel of the rectified one looks."""
    return camera.project(lens_map(camera).source.rays()).astype(np.float32)
