"""Small texts beside what they name; one that would cover another is moved, or left out."""

import cv2
import numpy as np

from warehouse_sim.dataset.overlay import Color, Image

_FONT, _SCALE = cv2.FONT_HERSHEY_SIMPLEX, 0.42
_TRIES = (0, -1, 1, -2, 2, -3, 3)
"""Line heights by which a text is moved until it is free."""


class Captions:
    """Texts for an image, the most important first.

    Args:
        image: Where they are drawn, in place.
    """

    def __init__(self, image: Image) -> None:
        self._image = image
        self._placed: list[tuple[str, tuple[int, int, int, int], Color]] = []

    def add(self, text: str, place: tuple[float, float], color: Color) -> None:
        """Find room for a text at ``place`` (px), or near it; where there is none it is left out."""
        (width, height), _ = cv2.getTextSize(text, _FONT, _SCALE, 1)
        width, height = width + 4, height + 6
        rows, columns = self._image.shape[:2]
        if not (-width < place[0] < columns + width and -height < place[1] < rows + height):
            return
        left = int(np.clip(place[0], 0, max(columns - width, 0)))
        for move in _TRIES:
            top = int(np.clip(place[1] - height / 2 + move * height, 0, max(rows - height, 0)))
            box = left, top, left + width, top + height
            if not any(_overlap(box, other) for _, other, _ in self._placed):
                self._placed.append((text, box, color))
                return

    def draw(self) -> None:
        """Draw them on dark bands in their colours."""
        for text, (left, top, right, bottom), color in self._placed:
            self._image[top:bottom, left:right] //= 4
            bright = tuple(int(128 + channel / 2) for channel in color)
            cv2.putText(self._image, text, (left + 2, bottom - 4), _FONT, _SCALE, bright, 1, cv2.LINE_AA)


def _overlap(a: tuple[int, int, int, int], b: tuple[int, int, int, int]) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]
