"""How targets are cut out of images."""

from dataclasses import dataclass
from typing import Annotated

from warehouse_sim.estimators.api import LeastVisible
from warehouse_sim.ranges import Fraction, Range, ranged

_MOST_SIDE_PX = 181
"""Pixels of a crop are numbered in 16 bits."""
_STORED_MARGIN = 0.5
"""Space around the mask in crops with surroundings, as a fraction of its longer side: half a neighbour on each side."""


@dataclass(frozen=True)
@ranged
class CropConfig:
    """How targets are cut out of images."""

    side_px: Annotated[int, Range(1, _MOST_SIDE_PX, "px")] | None = None
    """Side of the square crops in pixels, 1-181; none when the network reads the cloud alone."""
    rgb: bool = True
    """Keep colour in the square crop, where there is one."""
    depth: bool = False
    """Keep depth in the square crop, where there is one."""
    stored_points: Annotated[int, Range(1, 65_536)] = 1024
    """Most points kept of one target, 1-65,536; each training step draws its own from them."""
    min_points: Annotated[int, Range(1, 65_536)] = 32
    """Targets with fewer depth readings are left out, 1-65,536."""
    min_visible_fraction: Fraction = 0.1
    """Targets less visible than this are left out, 0-1."""
    margin: Annotated[float, Range(0, 10)] = 0.1
    """Space around the mask in the square crop, as a fraction of its longer side, 0-10."""
    surround_px: Annotated[int, Range(0, 1000, "px")] = 0
    """Least width of the rim about the mask's box whose pixels are kept, too, 0-1,000; 0 keeps those of the mask
    alone."""
    surround_fraction: Annotated[float, Range(0, 1)] = 0.0
    """Least width of that rim as a fraction of the box's longer side, 0-1."""

    @property
    def has_surroundings(self) -> bool:
        """Whether crops hold pixels around the mask, each with what the mask says of it."""
        return self.surround_px > 0

    @property
    def stored_side_px(self) -> int | None:
        """Side of the square crops as they are kept: of a crop with surroundings the network sees a part."""
        if self.side_px is None or not self.has_surroundings:
            return self.side_px
        return min(self.side_px * 3 // 2, _MOST_SIDE_PX)

    @property
    def stored_margin(self) -> float:
        """Space around the mask in the square crop as it is kept: masks that are too large find room in it."""
        return _STORED_MARGIN if self.has_surroundings else self.margin

    def rim_px(self, width: int, height: int) -> int:
        """Return how wide the rim about a box of this size (px) is."""
        return max(self.surround_px, round(self.surround_fraction * max(width, height)))

    @property
    def reads_rgb(self) -> bool:
        """Whether crops hold colour."""
        return self.side_px is not None and self.rgb

    @property
    def reads_depth(self) -> bool:
        """Whether crops hold depth."""
        return self.side_px is not None and self.depth

    @property
    def min_visible(self) -> LeastVisible:
        """Which targets of a dataset are cut out."""
        return LeastVisible(self.min_visible_fraction, self.min_points)

    def __post_init__(self) -> None:
        if self.side_px is not None and not (self.rgb or self.depth):
            raise ValueError(f"a square crop of {self.side_px} px must hold rgb or depth; leave it out for neither")
        if self.surround_fraction > 0 and not self.has_surroundings:
            raise ValueError("surround_fraction needs a surround_px of 1 or more")
