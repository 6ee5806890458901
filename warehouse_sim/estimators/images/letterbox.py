"""Scale images of any size to about as many pixels as a network was made for, on a canvas of a convenient size."""

from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Float, Shaped

from warehouse_sim.geometry.camera import PinholeCamera

Boxes = Float[np.ndarray, "k 4"]
"""Left, top, right, bottom of *edges*: a pixel (u, v) reaches from (u, v) to (u + 1, v + 1)."""


@dataclass(frozen=True)
class Letterbox:
    """An image scaled to ``inner_wh`` in the upper left of a canvas of ``size_wh``."""

    source_wh: tuple[int, int]
    """The image's own size (px)."""
    inner_wh: tuple[int, int]
    """Its size on the canvas (px)."""
    size_wh: tuple[int, int]
    """The canvas (px)."""

    @classmethod
    def fit(cls, source_wh: tuple[int, int], input_wh: tuple[int, int], multiple: int = 32) -> "Letterbox":
        """Return the scaling of an image to a canvas of about the area of ``input_wh`` in the image's own shape.

        Args:
            source_wh: Size of the image (px).
            input_wh: Size that the network was made for (px); what counts is its area.
            multiple: Both edges of the canvas are multiples of this (px).
        """
        width, height = source_wh
        scale = (input_wh[0] * input_wh[1] / (width * height)) ** 0.5
        canvas = tuple(max(1, round(edge * scale / multiple)) * multiple for edge in source_wh)
        scale = min(canvas[0] / width, canvas[1] / height)
        inner = tuple(max(1, min(round(edge * scale), limit)) for edge, limit in zip(source_wh, canvas, strict=True))
        return cls(source_wh, (inner[0], inner[1]), (canvas[0], canvas[1]))

    @property
    def scale_xy(self) -> Float[np.ndarray, " 2"]:
        """Pixels of the canvas for a pixel of the image, along each axis."""
        return np.array(self.inner_wh, dtype=float) / self.source_wh

    def smooth(self, image: Shaped[np.ndarray, "h w 3"], fill: int = 114) -> Shaped[np.ndarray, "ch cw 3"]:
        """Return colours averaged onto the canvas."""
        width, height = self.inner_wh
        shrinks = width < self.source_wh[0]
        scaled = cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR)
        canvas = np.full((self.size_wh[1], self.size_wh[0], 3), fill, dtype=image.dtype)
        canvas[:height, :width] = scaled
        return canvas

    def picked(self, image: Shaped[np.ndarray, "h w"]) -> Shaped[np.ndarray, "ch cw"]:
        """Return the values of the nearest pixels on the canvas, 0 beside the image; depths must never be mixed."""
        width, height = self.inner_wh
        columns, rows = (
            np.minimum(((np.arange(inner) + 0.5) * source / inner).astype(int), source - 1)
            for inner, source in zip(self.inner_wh, self.source_wh, strict=True)
        )
        canvas = np.zeros((self.size_wh[1], self.size_wh[0]), dtype=image.dtype)
        canvas[:height, :width] = image[rows[:, None], columns]
        return canvas

    def onto_canvas(self, boxes: Boxes) -> Boxes:
        """Return boxes of edges of the image as boxes of edges on the canvas."""
        return boxes * np.tile(self.scale_xy, 2)

    def off_canvas(self, boxes: Boxes) -> Boxes:
        """Return boxes of edges on the canvas as boxes of edges of the image, cut at its borders."""
        found = boxes / np.tile(self.scale_xy, 2)
        return np.clip(found, 0.0, np.tile(np.array(self.source_wh, dtype=float), 2))

    def focal_px(self, camera: PinholeCamera) -> float:
        """Return the focal length on the canvas (px)."""
        return float(np.sqrt(camera.fx * camera.fy * self.scale_xy.prod()))
