"""What any network is that gives boxes with scores, whoever wrote it."""

from abc import ABC, abstractmethod
from typing import Any

from jaxtyping import Float, UInt8
from torch import Tensor, nn


class BoxNetwork(nn.Module, ABC):
    """Detects in batches of images of one size.

    Args:
        classes: Number of classes.
    """

    def __init__(self, classes: int) -> None:
        super().__init__()
        self.classes = classes

    @abstractmethod
    def forward(self, rgb: UInt8[Tensor, "b h w 3"] | None, depth: Float[Tensor, "b h w"] | None) -> Any:
        """Return what ``decode`` takes.

        Args:
            rgb: Colours, if they are read.
            depth: Canonical depth (m), if it is read.
        """

    @abstractmethod
    def decode(self, raw: Any) -> tuple[Float[Tensor, "b n 4"], Float[Tensor, "b n k"]]:
        """Return boxes (edges on the canvas, px) and the score of each class (0-1)."""
