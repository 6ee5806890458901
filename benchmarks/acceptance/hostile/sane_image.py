"""Whether an image shows something."""

from pathlib import Path

import cv2
import numpy as np

_FARTHEST_DEPTH = 200.0
_LEAST_CONTRAST = 1.0
"""Standard deviation of the grey values of an image that shows something."""
_LARGEST_SHEET_PX = 20_000


def image_problem(path: Path, size_wh: tuple[int, int] | None = None) -> str | None:
    """Return what is wrong with a colour image, if anything: undecodable, of another size, one even colour."""
    if not path.is_file():
        return "was not written"
    image = cv2.imread(str(path), cv2.IMREAD_COLOR)
    if image is None:
        return "cannot be decoded"
    if size_wh is not None and image.shape[1::-1] != size_wh:
        return f"is {image.shape[1]} x {image.shape[0]}, not {size_wh[0]} x {size_wh[1]}"
    if max(image.shape) > _LARGEST_SHEET_PX:
        return f"is {image.shape[1]} x {image.shape[0]}"
    if image.std() < _LEAST_CONTRAST:
        return f"is blank: all about {image.mean():.0f} of 255"
    return None


def depth_problem(path: Path, steps_a_metre: float) -> str | None:
    """Return what is wrong with a 16-bit depth image, if anything: empty, or farther than any hall is long."""
    steps = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    if steps is None or steps.dtype != np.uint16:
        return "is no 16-bit image"
    if not steps.any():
        return "holds no reading"
    farthest = float(steps.max()) / steps_a_metre
    return f"reads {farthest:.0f} m" if farthest > _FARTHEST_DEPTH else None
