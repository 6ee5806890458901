"""What every network of the family is given: the cloud of each object, its image crops and its class."""

from typing import NamedTuple

import torch
from jaxtyping import Bool, Float, Int, UInt8
from torch import Tensor


class NetworkInput(NamedTuple):
    """B objects with N points each; lengths are normalised: about a centre, in half diameters of the object."""

    points: Float[Tensor, "b n 3"]
    """Measured points, axes of the camera (x right, y down, z forward)."""
    pixel: Int[Tensor, "b n"]
    """Row-major index into the square crops of the pixel that each point came from."""
    class_index: Int[Tensor, " b"]
    """Class of each object, in the order of the run folder's objects."""
    rgb: UInt8[Tensor, "b s s 3"] | None = None
    """Colour crops, 0-255; None for networks that read no colour."""
    depth: Float[Tensor, "b s s 2"] | None = None
    """Depth crops; None for networks that read no depth image. [0]: (z - z of the centre) in half diameters, clipped
    to -3..3, 0 where there is no reading. [1]: 1 where there is a reading, else 0."""
    inside: Float[Tensor, "b n"] | None = None
    """1 where the mask holds the point, else 0; None for networks that take all points for the object's."""
    level: Float[Tensor, " b"] | None = None
    """1 where the points stand upright by gravity, 0 where nobody knows where down is; None for networks that are not
    told."""

    def to(self, device: torch.device | str) -> "NetworkInput":
        """Return the same inputs on ``device``."""
        return NetworkInput(*(None if value is None else value.to(device) for value in self))  # type: ignore[arg-type]


class GroundTruth(NamedTuple):
    """The true pose of each object, normalised as its input is."""

    rotation: Float[Tensor, "b 3 3"]
    translation: Float[Tensor, "b 3"]
    class_index: Int[Tensor, " b"]
    belongs: Bool[Tensor, "b n"] | None = None
    """Which points are the object's; None where all are."""
