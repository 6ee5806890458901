"""Settings of a second camera and of the matcher."""

from dataclasses import dataclass, field


@dataclass(frozen=True)
class SgbmConfig:
    """Semi-global block matching (Hirschmueller 2008) as OpenCV does it."""

    disparities: int = 192
    """Largest disparity that is looked for (px), a multiple of 16; nearer things are not matched."""
    block_size: int = 5
    """Edge of the compared blocks (px), odd, 1-11."""
    uniqueness_percent: int = 10
    """By how much the best cost must beat the next, 0-100; higher leaves more holes and fewer errors."""
    speckle_px: int = 100
    """Patches smaller than this are removed (px), >= 0."""
    left_right_px: int = 1
    """Largest difference between matching from the left and from the right (px), >= 0."""

    def __post_init__(self) -> None:
        if self.disparities < 16 or self.disparities % 16:
            raise ValueError(f"disparities must be a multiple of 16, found {self.disparities}")
        if self.block_size not in range(1, 12, 2):
            raise ValueError(f"block_size must be odd and 1-11, found {self.block_size}")
        if not 0 <= self.uniqueness_percent <= 100 or min(self.speckle_px, self.left_right_px) < 0:
            raise ValueError("uniqueness_percent must be 0-100, speckle_px and left_right_px must not be negative")


@dataclass(frozen=True)
class StereoConfig:
    """A camera like the first, parallel to it, on its right; its noise has the first one's settings."""

    baseline: float = 0.54
    """Distance of the optical centres (m), > 0; KITTI's is 0.54."""
    matching: SgbmConfig | None = field(default_factory=SgbmConfig)
    """How a disparity is matched from the two noisy pictures; null = none is."""

    def __post_init__(self) -> None:
        if not self.baseline > 0:
            raise ValueError(f"baseline must be positive, found {self.baseline}")
