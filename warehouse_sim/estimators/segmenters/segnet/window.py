"""The part of an image about a box, stretched to a crop, and the way back."""

from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Float, Float32, Shaped

Edges = tuple[float, float, float, float]
"""Left, top, right, bottom of edges: a pixel (u, v) reaches from (u, v) to (u + 1, v + 1)."""


@dataclass(frozen=True)
class Window:
    """What is cut out: edges in the image (px), and the size of the crop (px)."""

    edges: Edges
    crop_wh: tuple[int, int]

    @classmethod
    def about(cls, box: Edges, margin: float, crop_wh: tuple[int, int]) -> "Window":
        """Return the window that shows a box of edges with a margin, as a fraction of its size, on each side."""
        left, top, right, bottom = box
        across, down = margin * max(right - left, 1.0), margin * max(bottom - top, 1.0)
        return cls((left - across, top - down, right + across, bottom + down), crop_wh)

    @property
    def scale_xy(self) -> Float[np.ndarray, " 2"]:
        """Pixels of the crop for a pixel of the image."""
        left, top, right, bottom = self.edges
        return np.array([self.crop_wh[0] / (right - left), self.crop_wh[1] / (bottom - top)])

    def matrix(self, mirrored: bool = False) -> Float[np.ndarray, "2 3"]:
        """Return the map of pixel centres of the image to those of the crop."""
        scale = self.scale_xy
        shift = (0.5 - np.array(self.edges[:2])) * scale - 0.5
        M = np.array([[scale[0], 0.0, shift[0]], [0.0, scale[1], shift[1]]])
        if mirrored:
            M[0] = [-M[0, 0], 0.0, self.crop_wh[0] - 1.0 - M[0, 2]]
        return M

    def picked(self, image: Shaped[np.ndarray, "h w"], mirrored: bool = False) -> Shaped[np.ndarray, "ch cw"]:
        """Return the values of the nearest pixels, 0 beyond the image."""
        return np.asarray(cv2.warpAffine(image, self.matrix(mirrored), self.crop_wh, flags=cv2.INTER_NEAREST))

    def smooth(self, image: Shaped[np.ndarray, "h w 3"], mirrored: bool = False) -> Shaped[np.ndarray, "ch cw 3"]:
        """Return colours, averaged where many pixels become one, grey beyond the image."""
        across, down = (max(1, round(1.0 / scale)) for scale in self.scale_xy)
        if max(across, down) > 1:
            left, top, right, bottom = (int(edge) for edge in self.edges)
            part = np.s_[max(0, top - 8) : max(0, bottom + 8), max(0, left - 8) : max(0, right + 8)]
            blurred = image.copy()
            if blurred[part].size:
                blurred[part] = cv2.blur(np.ascontiguousarray(image[part]), (across, down))
            image = blurred
        return np.asarray(
            cv2.warpAffine(image, self.matrix(mirrored), self.crop_wh, flags=cv2.INTER_LINEAR, borderValue=(114,) * 3)
        )

    def pasted(self, crop: Float32[np.ndarray, "ch cw"], size_wh: tuple[int, int]) -> Float32[np.ndarray, "h w"]:
        """Return a crop's values at the pixels of the image, 0 outside of the window."""
        back = cv2.invertAffineTransform(self.matrix())
        return np.asarray(cv2.warpAffine(crop, back, size_wh, flags=cv2.INTER_LINEAR))

    def to_crop(self, uv: Float[np.ndarray, "k 2"], mirrored: bool = False) -> Float[np.ndarray, "k 2"]:
        """Return points of the image (pixel centres at integers) as points of the crop."""
        M = self.matrix(mirrored)
        return uv @ M[:, :2].T + M[:, 2]

    def to_image(self, uv: Float[np.ndarray, "k 2"]) -> Float[np.ndarray, "k 2"]:
        """Return points of the crop as points of the image."""
        M = cv2.invertAffineTransform(self.matrix())
        return uv @ M[:, :2].T + M[:, 2]
