"""Where the rays of pixels lie, in the 32 bits that sensor models work in."""

from functools import lru_cache

import numpy as np
from jaxtyping import Float32

from warehouse_sim.geometry.camera import PinholeCamera


def pixel_tangents(camera: PinholeCamera) -> tuple[Float32[np.ndarray, "rows w"], Float32[np.ndarray, "h columns"]]:
    """Return x and y of each pixel's ray at z = 1; without a lens x is one row and y one column."""
    if camera.distortion is not None:
        return _lens_tangents(camera)
    x = (np.arange(camera.width, dtype=np.float32) - np.float32(camera.cx)) / np.float32(camera.fx)
    y = (np.arange(camera.height, dtype=np.float32) - np.float32(camera.cy)) / np.float32(camera.fy)
    return x[None, :], y[:, None]


@lru_cache(maxsize=4)
def pixel_stretch(camera: PinholeCamera) -> Float32[np.ndarray, "h w 2 2"]:
    """Return by how much the lens stretches the image at each pixel: the derivatives of ``Distortion.apply`` there."""
    assert camera.distortion is not None
    stretch = camera.distortion.jacobian(camera.rays()[..., :2]).astype(np.float32)
    stretch.setflags(write=False)
    return stretch


@lru_cache(maxsize=4)
def _lens_tangents(camera: PinholeCamera) -> tuple[Float32[np.ndarray, "h w"], Float32[np.ndarray, "h w"]]:
    x, y, _ = np.moveaxis(camera.rays().astype(np.float32), -1, 0)
    return np.ascontiguousarray(x), np.ascontiguousarray(y)
