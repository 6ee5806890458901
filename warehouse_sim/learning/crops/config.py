"""How targets are cut out of images."""

from dataclasses import dataclass

_MOST_SIDE_PX = 181
"""Pixels of a crop are numbered in 16 bits."""


@dataclass(frozen=True)
class CropConfig:
    """How targets are cut out of images."""

    side_px: int | None = None
    """Side of the square crops in pixels; none when the network reads the cloud alone."""
    rgb: bool = True
    """Keep colour in the square crop, where there is one."""
    depth: bool = False
    """Keep depth in the square crop, where there is one."""
    stored_points: int = 1024
    """Most points kept of one target, >= 1; each training step draws its own from them."""
    min_points: int = 32
    """Targets with fewer depth readings are left out, >= 1."""
    min_visible_fraction: float = 0.1
    """Targets less visible than this are left out, 0-1."""
    margin: float = 0.1
    """Space around the mask in the square crop, as a share of its longer side, >= 0."""

    @property
    def reads_rgb(self) -> bool:
        """Whether crops hold colour."""
        return self.side_px is not None and self.rgb

    @property
    def reads_depth(self) -> bool:
        """Whether crops hold depth."""
        return self.side_px is not None and self.depth

    def __post_init__(self) -> None:
        if self.side_px is not None and not 1 <= self.side_px <= _MOST_SIDE_PX:
            raise ValueError(f"side_px must be 1 to {_MOST_SIDE_PX}, found {self.side_px}")
        if self.side_px is not None and not (self.rgb or self.depth):
            raise ValueError(f"a square crop of {self.side_px} px must hold rgb or depth; leave it out for neither")
