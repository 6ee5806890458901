"""The pinhole camera: OpenCV axes (x right, y down, z forward), pixel centres at integers."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float


@dataclass(frozen=True)
class PinholeCamera:
    """Intrinsics of an undistorted camera; pixel (0, 0) has its centre at u = 0, v = 0."""

    width: int
    """Image width in pixels."""
    height: int
    """Image height in pixels."""
    fx: float
    """Focal length along u in pixels."""
    fy: float
    """Focal length along v in pixels."""
    cx: float
    """Principal point u in pixels, 0 at the centre of the first column."""
    cy: float
    """Principal point v in pixels, 0 at the centre of the first row."""

    def __post_init__(self) -> None:
        if self.width < 1 or self.height < 1:
            raise ValueError(f"a camera needs at least one pixel, found {self.width} x {self.height}")
        if self.fx <= 0 or self.fy <= 0:
            raise ValueError(f"focal lengths must be positive, found fx={self.fx}, fy={self.fy}")

    @classmethod
    def from_focal(cls, width: int, height: int, focal_px: float) -> "PinholeCamera":
        """Make a camera with square pixels and a centred principal point, ``((w - 1) / 2, (h - 1) / 2)``."""
        return cls(width, height, focal_px, focal_px, (width - 1) / 2, (height - 1) / 2)

    @property
    def K(self) -> Float[np.ndarray, "3 3"]:
        """The 3x3 intrinsic matrix."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    def project(self, points: Float[np.ndarray, "*batch 3"]) -> Float[np.ndarray, "*batch 2"]:
        """Return pixel coordinates (u, v) of points in the camera frame (m); z must be positive."""
        return points[..., :2] / points[..., 2:] * [self.fx, self.fy] + [self.cx, self.cy]

    def rays(self) -> Float[np.ndarray, "h w 3"]:
        """Return for each pixel the point of its ray at z = 1 m in the camera frame."""
        u, v = np.meshgrid(np.arange(self.width), np.arange(self.height))
        return np.stack([(u - self.cx) / self.fx, (v - self.cy) / self.fy, np.ones_like(u, dtype=float)], axis=-1)

    def unproject(self, depth: Float[np.ndarray, "h w"]) -> Float[np.ndarray, "h w 3"]:
        """Return camera-frame points (m) of a z-depth image (m); pixels without reading become the origin."""
        return self.rays() * depth[..., None]

    def crop(self, left: float, top: float, width: int, height: int, scale: float = 1.0) -> "PinholeCamera":
        """Return the camera that sees a window of this image, resampled by ``scale``.

        Args:
            left: u of the window's outer left edge plus half a pixel, i.e. the first column when whole.
            top: v of the first row.
            width: Width of the result in pixels.
            height: Height of the result in pixels.
            scale: Result pixels per source pixel.
        """
        # Edges, not centres, scale linearly: the first pixel's outer edge is at u = -0.5 in both images.
        cx = (self.cx - left + 0.5) * scale - 0.5
        cy = (self.cy - top + 0.5) * scale - 0.5
        return PinholeCamera(width, height, self.fx * scale, self.fy * scale, cx, cy)
