"""Heads: what is said at each point for the class of its object, at a cost that does not grow with their number.

Beyond the original, each point says where it lies on the object, and one pose is fitted to all. As in PVN3D (He et al.,
CVPR 2020) and FFB6D (CVPR 2021) the pose comes out of weighted least squares; the points here are the measured ones
themselves rather than votes for keypoints, and each brings the scale of its own error.
"""

from dataclasses import dataclass
from typing import Annotated, Literal

import torch
from jaxtyping import Float, Int
from torch import Tensor, nn
from torch.nn.functional import embedding

from warehouse_sim.estimators.pose.densefusion.losses import confidence_loss, coordinate_loss, loss_distance
from warehouse_sim.estimators.pose.densefusion.networks.interface import Coordinates, GroundTruth, Hypotheses, Proposal
from warehouse_sim.estimators.pose.densefusion.networks.points import point_layers
from warehouse_sim.estimators.pose.densefusion.networks.rotations import fit_pose, matrix_from_quat_wxyz
from warehouse_sim.estimators.pose.densefusion.objects import ShapeTensors
from warehouse_sim.estimators.pose.densefusion.settings import LossConfig
from warehouse_sim.ranges import Range, ranged

_SURFACE_HYPOTHESES = 16
"""Hypotheses of an object that losses over surface points look at, nearest and chamfer."""
_COORDINATE_WEIGHT = 0.01
"""Of the object coordinates against the pose that is fitted to them."""


class PerClassLinear(nn.Module):
    """A linear layer with weights of its own for each class: each object is multiplied with its class's only.

    Computed in 32 bits, because the result is a pose.

    Args:
        before: Channels of the input.
        after: Channels of the result.
        classes: Number of classes.
    """

    def __init__(self, before: int, after: int, classes: int) -> None:
        super().__init__()
        bound = before**-0.5
        self.weight = nn.Parameter(torch.empty(classes, before, after).uniform_(-bound, bound))
        self.bias = nn.Parameter(torch.empty(classes, after).uniform_(-bound, bound))

    def forward(self, x: Float[Tensor, "b n before"], class_index: Int[Tensor, " b"]) -> Float[Tensor, "b n after"]:
        """Return the result of each object's class."""
        with torch.autocast(x.device.type, enabled=False):
            weight = embedding(class_index, self.weight.flatten(1)).unflatten(1, self.weight.shape[1:])
            bias = embedding(class_index, self.bias)
            return torch.baddbmm(bias[:, None], x.float(), weight)


def class_bias(classes: int, width: int) -> nn.Embedding:
    """Return a table of one vector a class, zero at first, to be added to hidden features.

    With it a trunk that all classes share knows which object it looks at, say how long the sides are that it does not
    see; output layers alone, being linear, cannot bring that in. It costs one addition per object and channel.
    """
    table = nn.Embedding(classes, width)
    nn.init.zeros_(table.weight)
    return table


@dataclass(frozen=True)
@ranged
class HeadConfig:
    """Kind and sizes of the heads."""

    widths: Annotated[tuple[int, ...], Range(1, 8192)] = (256, 128)
    """Channels of the hidden layers, 1-8,192."""
    shared: bool = True
    """One trunk for all outputs; the original has one each for rotation, translation and confidence."""
    predicts: Literal["poses", "coordinates"] = "poses"
    """A pose at each point, or where each point lies on the object, to which one pose is fitted."""
    class_bias: bool = True
    """Whether the trunk knows the object's class, not only its last layer; not in the original."""
    training_points: Annotated[int, Range(1, 65_536)] | None = None
    """Points of each object whose outputs are computed in training, drawn afresh each time, 1-65,536; none for all, as
    the original. Outputs of one object's points say much the same, so a few of them train as well for less time."""


class SplitTrunk(nn.Module):
    """Hidden layers on [local, global], with the first layer split in two.

    ``W [local, global] = W_local local + W_global global``: the global part is the same for all points and
    is computed once, which gives the same numbers as tiling it.

    Args:
        local_channels: Channels of the per-point features.
        global_channels: Channels of the pooled features.
        widths: Channels of the hidden layers.
        classes: Number of classes that the first layer tells apart; 0 for none.
    """

    def __init__(self, local_channels: int, global_channels: int, widths: tuple[int, ...], classes: int = 0) -> None:
        super().__init__()
        self.from_local = nn.Linear(local_channels, widths[0])
        self.from_global = nn.Linear(global_channels, widths[0], bias=False)
        self.from_class = class_bias(classes, widths[0]) if classes else None
        self.rest = point_layers(*widths)

    def forward(
        self, local: Float[Tensor, "b n local"], whole: Float[Tensor, "b global"], class_index: Int[Tensor, " b"]
    ) -> Float[Tensor, "b n out"]:
        """Return hidden features of each point."""
        shared = self.from_global(whole)
        if self.from_class is not None:
            shared = shared + self.from_class(class_index)
        hidden = self.from_local(local)
        return self.rest(torch.relu_(hidden + shared[:, None].to(hidden.dtype)))


class PoseHeads(nn.Module):
    """Predict rotation, offset and confidence at each point for the object's class.

    Args:
        config: Widths.
        local_channels: Channels of the per-point features.
        global_channels: Channels of the pooled features.
        classes: Number of CAD geometries that the network knows.
    """

    _OUTPUTS = (4, 3, 1)

    def __init__(self, config: HeadConfig, local_channels: int, global_channels: int, classes: int) -> None:
        super().__init__()
        known = classes if config.class_bias else 0
        # The rotation is among the first output layer's values, shared or not.
        sizes = (sum(self._OUTPUTS),) if config.shared else self._OUTPUTS
        self.trunks = nn.ModuleList(SplitTrunk(local_channels, global_channels, config.widths, known) for _ in sizes)
        self.outputs = nn.ModuleList(PerClassLinear(config.widths[-1], size, classes) for size in sizes)

    @torch.no_grad()
    def start_rotation(self, class_index: int, quat_wxyz: Float[Tensor, " 4"]) -> None:
        """Make an untrained network propose about this rotation for a class."""
        self.outputs[0].get_parameter("bias")[class_index, :4] = quat_wxyz

    def forward(
        self,
        local: Float[Tensor, "b n local"],
        whole: Float[Tensor, "b global"],
        points: Float[Tensor, "b n 3"],
        class_index: Int[Tensor, " b"],
        trust: Float[Tensor, "b n"] | None = None,
    ) -> Proposal:
        """Return one pose a point of ``points`` for the class of each object, whatever the ``trust`` in the point."""
        values = torch.cat(
            [
                output(trunk(local, whole, class_index), class_index)
                for trunk, output in zip(self.trunks, self.outputs, strict=True)
            ],
            dim=-1,
        )
        quat, offset, logit = values.split(self._OUTPUTS, dim=-1)
        return Proposal(Hypotheses(quat, points.float() + offset, logit[..., 0]))

    @staticmethod
    def loss(proposal: Proposal, gt: GroundTruth, shapes: ShapeTensors, config: LossConfig) -> Float[Tensor, ""]:
        """Return the confidence loss of the poses of all points that are the object's."""
        found, belongs = proposal.hypotheses, gt.belongs
        if config.reads_surface:
            # Points are in random order: the first few are a fair sample of them.
            found = Hypotheses(*(values[:, :_SURFACE_HYPOTHESES] for values in found))
        if belongs is not None:
            belongs = belongs[:, : found.logit.shape[1]]
        rotation = matrix_from_quat_wxyz(found.quat_wxyz)
        distance = loss_distance(rotation, found.translation, gt, shapes, config)
        return confidence_loss(distance, found.logit, config.confidence_weight, belongs)


class InlierHead(nn.Module):
    """Say of each point whether it is the object's, before the points are summed up to an object.

    The points in the mask and those around it are summed up apart: what all points of a mask have in common, and what
    is around it, is what a point is compared with.

    Args:
        channels: Channels of the points' features.
        classes: Number of CAD geometries that the network knows.
    """

    _SUMMARY, _WIDTHS = 64, (64, 32)
    """Channels of what is summed up over the points, and of the hidden layers."""

    def __init__(self, channels: int, classes: int) -> None:
        super().__init__()
        self.summary = point_layers(channels, self._SUMMARY)
        self.trunk = SplitTrunk(channels, 3 * self._SUMMARY, self._WIDTHS, classes)
        self.output = nn.Linear(self._WIDTHS[-1], 1)

    def forward(
        self, features: Float[Tensor, "b n c"], inside: Float[Tensor, "b n"], class_index: Int[Tensor, " b"]
    ) -> Float[Tensor, "b n"]:
        """Return the trust in each point before the sigmoid.

        Args:
            features: Of each point.
            inside: 1 where the mask holds the point, else 0.
            class_index: Class of each object.
        """
        deep = self.summary(features)
        within = inside[..., None].to(deep.dtype)
        held, rest = deep * within, deep * (1.0 - within)
        fraction = within.mean(dim=1)
        # A small number keeps the average defined where the mask holds all points, or none.
        whole = [held.mean(dim=1) / (fraction + 1e-3), held.amax(dim=1), rest.mean(dim=1) / (1.0 - fraction + 1e-3)]
        hidden = self.trunk(features, torch.cat(whole, dim=-1), class_index)
        return self.output(hidden)[..., 0].float()


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
        return distance.mean() + _COORDINATE_WEIGHT * likelihood + trust
