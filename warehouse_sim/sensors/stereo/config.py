"""Settings of a second camera and of the matcher."""

from dataclasses import dataclass, field
from typing import Annotated

from warehouse_sim.ranges import Range, ranged


@dataclass(frozen=True)
@ranged
class SgbmConfig:
    """Semi-global block matching (Hirschmueller 2008) as OpenCV does it."""

    disparities: Annotated[int, Range(16, 1024, "px")] = 192
    """Largest disparity that is looked for (px), a multiple of 16, 16-1,024; nearer things are not matched."""
    block_size: Annotated[int, Range(1, 11, "px")] = 5
    """Edge of the compared blocks (px), odd, 1-11."""
    uniqueness_percent: Annotated[int, Range(0, 100, "%")] = 10
    """By how much the best cost must beat the next, 0-100; higher leaves more holes and fewer errors."""
    speckle_px: Annotated[int, Range(0, 100_000, "px")] = 100
    """Patches smaller than this are removed (px), 0-100,000."""
    left_right_px: Annotated[int, Range(0, 1000, "px")] = 1
    """Largest difference between matching from the left and from the right (px), 0-1,000."""

    def __post_init__(self) -> None:
        if self.disparities % 16:
            raise ValueError(f"disparities must be a multiple of 16, found {self.disparities}")
        if self.block_size % 2 == 0:
            raise ValueError(f"block_size must be odd, found {self.block_size}")


@dataclass(frozen=True)
@ranged
class StereoConfig:
    """A camera like the first, parallel to it, on its right; its noise has the first one's settings."""

    baseline: Annotated[float, Range(0.001, 2, "m")] = 0.54
    """Distance of the optical centres (m), 0.001-2; KITTI's is 0.54."""
    matching: SgbmConfig | None = field(default_factory=SgbmConfig)
    """How a disparity is matched from the two noisy images; null = none is."""
