"""Disparity of a rectified pair: true from depth, or matched from two images; and the settings of the pair."""

from dataclasses import dataclass, field
from typing import Annotated

import cv2
import numpy as np
from jaxtyping import Bool, Float32, UInt8

from warehouse_sim.ranges import Range, ranged

_STEPS = 16.0
"""OpenCV returns disparities in sixteenths of a pixel."""
_BLOCK_PX = 5
"""Edge of the blocks that are compared."""
_UNIQUENESS_PERCENT = 10
"""By how much the best cost must beat the next; higher leaves more holes and fewer errors."""
_SPECKLE_PX = 100
"""Patches smaller than this are removed."""
_LEFT_RIGHT_PX = 1
"""Largest difference between matching from the left and from the right."""
_SAME_PX = 1.0
"""How far apart disparities of one surface may be in the two images (px)."""


@dataclass(frozen=True)
@ranged
class SgbmConfig:
    """Semi-global block matching (Hirschmueller 2008) as OpenCV does it."""

    disparities: Annotated[int, Range(16, 1024, "px")] = 192
    """Largest disparity that is looked for (px), a multiple of 16, 16-1,024; nearer things are not matched."""

    def __post_init__(self) -> None:
        if self.disparities % 16:
            raise ValueError(f"disparities must be a multiple of 16, found {self.disparities}")


@dataclass(frozen=True)
@ranged
class StereoConfig:
    """A camera like the first, parallel to it, on its right; its noise has the first one's settings."""

    baseline: Annotated[float, Range(0.001, 2, "m")] = 0.54
    """Distance of the optical centres (m), 0.001-2; KITTI's is 0.54."""
    matching: SgbmConfig | None = field(default_factory=SgbmConfig)
    """How a disparity is matched from the two noisy images; null = none is."""


def gt_disparity(depth: Float32[np.ndarray, "h w"], focal_px: float, baseline: float) -> Float32[np.ndarray, "h w"]:
    """Return the disparity ``d = f b / z`` (px) of a clean depth image (m), 0 where there is nothing.

    What the left camera sees at column u, the right one has at u - d, unless something hides it there.
    """
    seen = depth > 0
    return np.where(seen, focal_px * baseline / np.where(seen, depth, 1.0), 0.0).astype(np.float32)


def seen_in_both(left: Float32[np.ndarray, "h w"], right: Float32[np.ndarray, "h w"]) -> Bool[np.ndarray, "h w"]:
    """Return which pixels of the left image the right camera sees, too.

    A pixel at column u with disparity d is seen at u - d, if that is in the right image and one of the two columns
    there has the same disparity. This is the check of left against right (Fua 1993) on the ground truth; what fails it
    is hidden by something nearer, or outside.

    Args:
        left: True disparity of the left image (px), 0 = nothing there.
        right: True disparity of the right image (px), 0 = nothing there.
    """
    height, width = left.shape
    there = np.arange(width, dtype=np.float32) - left
    before = np.clip(there, 0, width - 1).astype(np.int32)
    after = np.minimum(before + 1, width - 1)
    row = width * np.arange(height, dtype=np.int32)[:, None]
    # Grazing surfaces change by almost a pixel from column to column, what hides others by more.
    same = np.abs(np.take(right, row + before) - left) <= _SAME_PX
    same |= np.abs(np.take(right, row + after) - left) <= _SAME_PX
    return same & (left > 0) & (there >= 0)


def match_sgbm(
    left: UInt8[np.ndarray, "h w 3"], right: UInt8[np.ndarray, "h w 3"], config: SgbmConfig
) -> Float32[np.ndarray, "h w"]:
    """Return the disparity (px) of the left image that semi-global matching finds, 0 = none.

    The costs of steps of one and of more pixels are 8 and 32 times channels times block area, as OpenCV advises. The
    mode with five directions runs on one thread, so that the same images give the same bytes.
    """
    area = 3 * _BLOCK_PX**2
    matcher = cv2.StereoSGBM.create(
        minDisparity=0,
        numDisparities=config.disparities,
        blockSize=_BLOCK_PX,
        P1=8 * area,
        P2=32 * area,
        disp12MaxDiff=_LEFT_RIGHT_PX,
        uniquenessRatio=_UNIQUENESS_PERCENT,
        speckleWindowSize=_SPECKLE_PX,
        speckleRange=2,
        mode=cv2.STEREO_SGBM_MODE_SGBM,
    )
    # OpenCV gives no value in the first columns, where the largest disparity leaves the image: a margin does it.
    margin = config.disparities
    wide = [cv2.copyMakeBorder(_grey(rgb), 0, 0, margin, 0, cv2.BORDER_REPLICATE) for rgb in (left, right)]
    found = matcher.compute(*wide)[:, margin:].astype(np.float32) / np.float32(_STEPS)
    columns = np.arange(found.shape[1], dtype=np.float32)
    return np.where((found > 0) & (found <= columns), found, np.float32(0.0))


def _grey(rgb: UInt8[np.ndarray, "h w 3"]) -> UInt8[np.ndarray, "h w"]:
    return cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY)
