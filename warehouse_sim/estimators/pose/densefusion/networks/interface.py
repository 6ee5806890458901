"""What networks of the family read, and what they propose."""

from typing import NamedTuple

import torch
from jaxtyping import Bool, Float, Int, UInt8
from torch import Tensor

from warehouse_sim.estimators.pose.densefusion.networks.rotations import matrix_from_quat_wxyz


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
    """1 where the points stand upright by gravity, 0 if gravity is unknown; None for networks without
    this input."""

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


class Hypotheses(NamedTuple):
    """Poses that are proposed for each object."""

    quat_wxyz: Float[Tensor, "b m 4"]
    """Rotation, not normalised."""
    translation: Float[Tensor, "b m 3"]
    """Object origin."""
    logit: Float[Tensor, "b m"]
    """Confidence before the sigmoid."""

    def most_confident(self) -> tuple[Float[Tensor, "b 3 3"], Float[Tensor, "b 3"]]:
        """Return rotation and translation of each object's most confident hypothesis."""
        rows = torch.arange(len(self.logit), device=self.logit.device)
        best = self.logit.argmax(dim=1)
        return matrix_from_quat_wxyz(self.quat_wxyz[rows, best]), self.translation[rows, best]


class Coordinates(NamedTuple):
    """Where measured points lie on each object."""

    points: Float[Tensor, "b n 3"]
    """The measured points."""
    object_points: Float[Tensor, "b n 3"]
    """The same points in the object's frame, as predicted."""
    log_scale: Float[Tensor, "b n"]
    """ln of the scale of each prediction's error."""


class Inliers(NamedTuple):
    """Which points are the object's, as predicted."""

    logit: Float[Tensor, "b n"]
    """Trust in each point before the sigmoid."""
    pose_logit: Float[Tensor, "b m"]
    """Confidence of each hypothesis before the sigmoid, if its point is the object's."""


class Proposal(NamedTuple):
    """What a network says of each object."""

    hypotheses: Hypotheses
    """One a point, or a single one that was fitted to object coordinates."""
    coordinates: Coordinates | None = None
    """Object coordinates of the points, where the head predicts them."""
    inliers: Inliers | None = None
    """Which points are the object's, where the network says it."""
