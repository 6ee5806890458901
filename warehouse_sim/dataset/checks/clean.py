"""Whether a clean depth image is the ground truth behind a reading."""

import numpy as np
from jaxtyping import Num

NOT_ITS_GT = "is not the ground truth behind the depth that was read"
# Depth sensors err by a few per cent, at edges by more; an image of another place errs by much more.
_LARGEST_ERROR = 0.2
_ENOUGH_READINGS = 100


def matches_reading(clean: Num[np.ndarray, "h w"], read: Num[np.ndarray, "h w"]) -> bool:
    """Return whether most readings lie near the clean depth, both in the same unit, 0 = none; a few say nothing."""
    if clean.shape != read.shape:
        return False
    readings = int((read > 0).sum())
    both = (clean > 0) & (read > 0)
    if readings < _ENOUGH_READINGS:
        return True
    gt = clean[both].astype(np.float64)
    return 2 * len(gt) > readings and bool(np.median(np.abs(read[both] - gt) / gt) < _LARGEST_ERROR)
