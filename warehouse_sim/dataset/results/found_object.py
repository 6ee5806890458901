"""What somebody found in an image of a dataset: what files of detections hold and scores compare."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool


@dataclass(frozen=True, eq=False)
class FoundObject:
    """One object that somebody found in an image of a dataset."""

    scene_id: int
    image_id: int
    score: float
    """Trust in it, 0-1."""
    class_name: str = ""
    """Its class; empty where nobody knows."""
    model: str | int | None = None
    """Which object of the dataset it is; None where nobody knows more than the class."""
    edges: tuple[float, float, float, float] | None = None
    """Left, top, right, bottom of its box (px): a pixel (u, v) reaches from (u, v) to (u + 1, v + 1)."""
    mask: Bool[np.ndarray, "h w"] | None = None
    """Its pixels."""
