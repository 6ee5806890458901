"""How images become inputs of a network; free of torch."""

from dataclasses import dataclass
from typing import Annotated, Literal

from warehouse_sim.ranges import Fraction, Range, ranged

DepthSource = Literal["camera", "lidar"]
Reading = Literal["rgb", "depth"]
Reads = tuple[Reading, ...]


@dataclass(frozen=True)
@ranged
class ImageConfig:
    """What is read of images, and how large."""

    reads: Reads = ("rgb",)
    """Inputs, in the order of their channels."""
    input_wh: Annotated[tuple[int, int], Range(32, 8192, "px")] = (640, 192)
    """Size that images are scaled to, 32-8,192; images of another shape keep theirs and get the same area."""
    depth_source: DepthSource = "camera"
    """Where depth comes from: the depth camera, or sweeps of the main LiDAR, projected and upsampled."""
    faces: bool = False
    """Whether faces of pallets have labels of their own."""


@dataclass(frozen=True)
@ranged
class ImageAugmentConfig:
    """How strongly whole images are disturbed in training."""

    zoom: Annotated[float, Range(1, 10)] = 1.5
    """Largest factor by which images are enlarged or shrunk, 1-10."""
    camera: Fraction = 0.0
    """Fraction of colour images that look as another camera's: paler or richer, softer or sharper, noisier, 0-1."""
