"""A sheet to print on: drawn at twice its size and reduced, so that letters have soft edges.

Places are fractions of the sheet's height: (0, 0) is its upper left corner, (aspect, 1) its lower right one. Codes are
drawn in whole pixels of the result, so that they stay readable.
"""

from collections.abc import Sequence

import cv2
import numpy as np
import segno
from jaxtyping import Bool, UInt8

WIDTH_PX, HEIGHT_PX = 544, 384
"""Size of a picture: the aspect of the A series of paper, and three pixels a module for a GS1-128 of an SSCC."""
ASPECT = WIDTH_PX / HEIGHT_PX
Ink = tuple[int, int, int]
BLACK: Ink = (24, 24, 26)
_FINER = 2


class Sheet:
    """Ink on paper, or on nothing.

    Args:
        paper: sRGB colour, or None where only the ink covers.
    """

    def __init__(self, paper: Ink | None = None) -> None:
        size = (_FINER * HEIGHT_PX, _FINER * WIDTH_PX)
        self._colour = np.full((*size, 3), paper or BLACK, np.uint8)
        self._cover = np.full(size, 0 if paper is None else 255, np.uint8)
        self._unit = float(size[0])

    def text(self, words: str, left: float, top: float, height: float, ink: Ink = BLACK, bold: bool = False) -> float:
        """Write a line whose capitals are ``height`` high and return where it ends."""
        font = cv2.FONT_HERSHEY_DUPLEX if bold else cv2.FONT_HERSHEY_SIMPLEX
        scale = height * self._unit / 21.0  # capitals of these fonts are 21 px high
        thick = max(1, round(scale * (4.0 if bold else 2.2)))
        place = round(left * self._unit), round((top + height) * self._unit)
        for image, value in ((self._colour, ink), (self._cover, 255)):
            cv2.putText(image, words, place, font, scale, value, thick, cv2.LINE_AA)
        return left + cv2.getTextSize(words, font, scale, thick)[0][0] / self._unit

    def polygon(self, points: Sequence[tuple[float, float]], ink: Ink = BLACK) -> None:
        """Fill an outline."""
        corners = np.rint(np.array(points) * self._unit).astype(np.int32)
        for image, value in ((self._colour, ink), (self._cover, 255)):
            cv2.fillPoly(image, [corners], value, cv2.LINE_AA)

    def rectangle(self, left: float, top: float, right: float, bottom: float, ink: Ink = BLACK) -> None:
        """Fill an upright rectangle."""
        self.polygon(((left, top), (right, top), (right, bottom), (left, bottom)), ink)

    def frame(self, left: float, top: float, right: float, bottom: float, line: float, ink: Ink = BLACK) -> None:
        """Draw the four edges of a rectangle, ``line`` wide inwards."""
        self.rectangle(left, top, right, top + line, ink)
        self.rectangle(left, bottom - line, right, bottom, ink)
        self.rectangle(left, top, left + line, bottom, ink)
        self.rectangle(right - line, top, right, bottom, ink)

    def bars(self, dark: Bool[np.ndarray, " modules"], left: float, top: float, width: float, height: float) -> None:
        """Draw a bar code as wide as whole pixels a module allow, in the middle of ``width``."""
        self._modules(dark[None], left, top, width, height, None)

    def qr(self, content: str, left: float, top: float, edge: float) -> None:
        """Draw a QR code (ISO/IEC 18004) with medium error correction."""
        code = segno.make_qr(content, error="m")
        self._modules(np.array(code.matrix, bool), left, top, edge, edge, 1)

    def picture(self) -> UInt8[np.ndarray, "384 544 4"]:
        """Return the sheet: sRGB, and how much it covers."""
        size, area = (WIDTH_PX, HEIGHT_PX), cv2.INTER_AREA
        cover = cv2.resize(self._cover, size, interpolation=area)
        # Ink that covers nothing must not mix into the colour of what does.
        weight = cv2.cvtColor(self._cover, cv2.COLOR_GRAY2BGR)
        light = cv2.resize(cv2.multiply(self._colour, weight, scale=1 / 255.0), size, interpolation=area)
        colour = cv2.divide(light, cv2.cvtColor(np.maximum(cover, 1), cv2.COLOR_GRAY2BGR), scale=255.0)
        return np.dstack([colour, cover])

    def _modules(
        self, dark: Bool[np.ndarray, "r c"], left: float, top: float, width: float, height: float, square: int | None
    ) -> None:
        pixel = max(1, int(width * HEIGHT_PX / dark.shape[1]))
        rows = pixel if square else round(height * HEIGHT_PX)
        image = np.kron(dark, np.ones((rows * _FINER, pixel * _FINER), bool))
        x = _FINER * (round(left * HEIGHT_PX) + max(0, int(width * HEIGHT_PX - pixel * dark.shape[1]) // 2))
        y = _FINER * round(top * HEIGHT_PX)
        image = image[: len(self._cover) - y, : self._cover.shape[1] - x]
        part = slice(y, y + image.shape[0]), slice(x, x + image.shape[1])
        self._colour[part][image] = BLACK
        self._cover[part][image] = 255
