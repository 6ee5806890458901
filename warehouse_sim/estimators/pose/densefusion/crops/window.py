"""The square part of an image around a target, and how it is resampled to a crop."""

from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Float, Float32, Int32, UInt8

from warehouse_sim.geometry.camera import PinholeCamera

_RAY_GRID = 5
"""Rows and columns of the rays to which a crop's ray map is fitted."""


@dataclass(frozen=True)
class Window:
    """A square window of an image, possibly reaching beyond it, that is resampled to a crop."""

    left: int
    top: int
    side: int
    """Side in image pixels."""

    @classmethod
    def around(cls, box_xyxy: tuple[int, int, int, int], margin: float) -> "Window":
        """Return the square about a box of inclusive pixel corners."""
        left, top, right, bottom = box_xyxy
        width, height = right - left + 1, bottom - top + 1
        side = int(np.ceil(max(width, height) * (1.0 + 2.0 * margin)))
        return cls(left - (side - width) // 2, top - (side - height) // 2, side)

    def cut_rgb(self, image: UInt8[np.ndarray, "h w 3"], side_px: int) -> UInt8[np.ndarray, "s s 3"]:
        """Return the colours, averaged over each crop pixel; black beyond the image."""
        height, width = image.shape[:2]
        right, bottom = self.left + self.side, self.top + self.side
        inside = image[max(self.top, 0) : min(bottom, height), max(self.left, 0) : min(right, width)]
        missing = max(-self.top, 0), max(bottom - height, 0), max(-self.left, 0), max(right - width, 0)
        whole = cv2.copyMakeBorder(inside, *missing, cv2.BORDER_CONSTANT, value=(0, 0, 0))
        return cv2.resize(whole, (side_px, side_px), interpolation=cv2.INTER_AREA).astype(np.uint8)

    def cut_depth(self, depth: Float32[np.ndarray, "h w"], side_px: int) -> Float32[np.ndarray, "s s"]:
        """Return the reading (m) at the centre of each crop pixel, 0 where there is none.

        Depth is never averaged: between an object and what lies behind it there is no surface.
        """
        height, width = depth.shape
        steps = (2 * np.arange(side_px) + 1) * self.side // (2 * side_px)
        u, v = self.left + steps, self.top + steps
        crop = depth[np.clip(v, 0, height - 1)[:, None], np.clip(u, 0, width - 1)]
        crop[(v < 0) | (v >= height), :] = 0.0
        crop[:, (u < 0) | (u >= width)] = 0.0
        return crop

    def ray_map(self, camera: PinholeCamera, side_px: int) -> Float[np.ndarray, "2 3"]:
        """Return the matrix that maps (column, row, 1) of a crop pixel to its ray (x / z, y / z).

        For a camera without distortion these are the first rows of the inverse of the crop's own intrinsics; with
        distortion they are the best fit over the window.
        """
        height, width = camera.height, camera.width
        # To the outer borders of the pixels that the window and the image share: beyond it a lens says nothing.
        u = np.linspace(max(self.left, 0) - 0.5, min(self.left + self.side, width) - 0.5, _RAY_GRID)
        v = np.linspace(max(self.top, 0) - 0.5, min(self.top + self.side, height) - 0.5, _RAY_GRID)
        u, v = (grid.ravel() for grid in np.meshgrid(u, v))
        # Edges, not centres, scale linearly: a pixel's outer edge lies half a pixel before its centre.
        scale = side_px / self.side
        column, row = (u - self.left + 0.5) * scale - 0.5, (v - self.top + 0.5) * scale - 0.5
        crop_pixels = np.stack([column, row, np.ones_like(row)], axis=-1)
        return np.linalg.lstsq(crop_pixels, camera.tangents_at(u, v), rcond=None)[0].T

    def index(self, u: Int32[np.ndarray, " n"], v: Int32[np.ndarray, " n"], side_px: int) -> Int32[np.ndarray, " n"]:
        """Return the row-major index of the crop pixel that covers each image pixel's centre."""
        column = (2 * (u - self.left) + 1) * side_px // (2 * self.side)
        row = (2 * (v - self.top) + 1) * side_px // (2 * self.side)
        return (row * side_px + column).astype(np.int32)
