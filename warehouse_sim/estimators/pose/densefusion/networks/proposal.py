"""What a network proposes for each object, in normalised units (length 1 = half a diameter)."""

from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor

from warehouse_sim.estimators.pose.densefusion.rotations import matrix_from_quat_wxyz


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
