"""How targets are cut out of images."""

from dataclasses import dataclass
from typing import Annotated

from warehouse_sim.estimators.visibility import LeastVisible
from warehouse_sim.ranges import Range, Share, ranged

_MOST_SIDE_PX = 181
"""Pixels of a crop are numbered in 16 bits."""


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
    min_visible_fraction: Share = 0.1
    """Targets less visible than this are left out, 0-1."""
    margin: Annotated[float, Range(0, 10)] = 0.1
    """Space around the mask in the square crop, as a share of its longer side, 0-10."""

    @property
    def reads_rgb(self) -> bool:
        """Whether crops hold colour."""
        return self.side_px is not None and self.rgb

    @property
    def reads_depth(self) -> bool:
        """Whether crops hold depth."""
        return self.side_px is not None and self.depth

    @property
    def least_visible(self) -> LeastVisible:
        """Which targets of a dataset are cut out."""
        return LeastVisible(self.min_visible_fraction, self.min_points)

    def __post_init__(self) -> None:
        if self.side_px is not None and not (self.rgb or self.depth):
            raise ValueError(f"a square crop of {self.side_px} px must hold rgb or depth; leave it out for neither")
