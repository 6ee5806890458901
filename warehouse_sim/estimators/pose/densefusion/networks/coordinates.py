"""A head beyond the original: each point says where it lies on the object, and one pose is fitted to all.

As in PVN3D (He et al., CVPR 2020) and FFB6D (CVPR 2021) the pose comes out of weighted least squares; the points here
are the measured ones themselves rather than votes for keypoints, and each brings the scale of its own error.
"""

import torch
from jaxtyping import Float, Int
from torch import Tensor, nn

from warehouse_sim.estimators.pose.densefusion.losses import confidence_loss, coordinate_loss, loss_distance
from warehouse_sim.estimators.pose.densefusion.networks.heads import HeadConfig, PerClassLinear, SplitTrunk
from warehouse_sim.estimators.pose.densefusion.networks.interface import Coordinates, GroundTruth, Hypotheses, Proposal
from warehouse_sim.estimators.pose.densefusion.networks.rotations import fit_pose, matrix_from_quat_wxyz
from warehouse_sim.estimators.pose.densefusion.objects import ShapeTensors
from warehouse_sim.estimators.pose.densefusion.settings import LossConfig

# Scales of errors in half diameters: from a fraction of a millimetre to several objects.
_LOG_SCALE_RANGE = -7.0, 2.0
_LEAST_TRUST = 1e-4


class CoordinateHeads(nn.Module):
    """Predict object coordinates and their scale at each point for the object's class, and fit one pose to them.

    Coordinates are predicted as an offset from the point seen in the object's mean orientation. The confidence of the
    fitted pose comes from the points' features, their scales and how well they agree.

    Args:
        config: Widths.
        local_channels: Channels of the per-point features.
        global_channels: Channels of the pooled features.
        classes: Number of CAD geometries that the network knows.
    """

    start: Tensor

    def __init__(self, config: HeadConfig, local_channels: int, global_channels: int, classes: int) -> None:
        super().__init__()
        known = classes if config.class_bias else 0
        self.trunk = SplitTrunk(local_channels, global_channels, config.widths, known)
        self.output = PerClassLinear(config.widths[-1], 4, classes)
        self.confidence = PerClassLinear(config.widths[-1] + 2, 1, classes)
        self.register_buffer("start", torch.eye(3).repeat(classes, 1, 1))

    @torch.no_grad()
    def start_rotation(self, class_index: int, quat_wxyz: Float[Tensor, " 4"]) -> None:
        """Make an untrained network propose about this rotation for a class."""
        self.start[class_index] = matrix_from_quat_wxyz(quat_wxyz)

    def forward(
        self,
        local: Float[Tensor, "b n local"],
        whole: Float[Tensor, "b global"],
        points: Float[Tensor, "b n 3"],
        class_index: Int[Tensor, " b"],
        trust: Float[Tensor, "b n"] | None = None,
    ) -> Proposal:
        """Return object coordinates of ``points`` and the pose that fits them, weighted by ``trust`` (0-1)."""
        points, hidden = points.float(), self.trunk(local, whole, class_index)
        offset, log_scale = self.output(hidden, class_index).split((3, 1), dim=-1)
        object_points = points @ self.start[class_index] + offset
        log_scale = log_scale[..., 0].clamp(*_LOG_SCALE_RANGE)
        # Weights fall with the square of the scale.
        uncertainty = 0.0 if trust is None else 0.5 * trust.float().clamp(min=_LEAST_TRUST).log()
        quat, translation, weights = fit_pose(object_points, points, log_scale - uncertainty)
        with torch.no_grad():
            fitted = object_points @ matrix_from_quat_wxyz(quat).mT + translation[:, None]
            misfit = (weights * (points - fitted).norm(dim=-1)).sum(dim=1, keepdim=True)
            agreement = torch.cat([(misfit + 1e-4).log(), (weights * log_scale).sum(dim=1, keepdim=True)], dim=-1)
        summary = (weights.detach()[:, None] @ hidden.float())[:, 0]
        logit = self.confidence(torch.cat([summary, agreement], dim=-1)[:, None], class_index)[..., 0]
        hypotheses = Hypotheses(quat[:, None], translation[:, None], logit)
        return Proposal(hypotheses, Coordinates(points, object_points, log_scale))

    @staticmethod
    def loss(proposal: Proposal, gt: GroundTruth, shapes: ShapeTensors, config: LossConfig) -> Float[Tensor, ""]:
        """Return the likelihood of the coordinates, the distance of the fitted pose and its confidence's loss."""
        found, coordinates, _ = proposal
        assert coordinates is not None
        rotation = matrix_from_quat_wxyz(found.quat_wxyz)
        distance = loss_distance(rotation, found.translation, gt, shapes, config)
        belongs = None if gt.belongs is None else gt.belongs[:, : coordinates.points.shape[1]]
        likelihood = coordinate_loss(
            coordinates.object_points,
            coordinates.log_scale,
            coordinates.points,
            gt,
            shapes,
            config.symmetry,
            belongs,
        )
        # The pose is trained whatever its confidence, there being only one.
        trust = confidence_loss(distance.detach(), found.logit, config.confidence_weight)
        return distance.mean() + config.coordinate_weight * likelihood + trust
