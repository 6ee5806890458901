"""Losses between predicted and true poses, in normalised units and over each object's symmetry group.

The distance of two poses is the RMS distance of the model's surface points. It depends on the surface through its mean
and covariance only, so four anchor points with the same moments give it exactly, and the minimum over a finite group
costs little.
"""

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor
from torch.nn.functional import logsigmoid

from warehouse_sim.estimators.pose.densefusion.networks.interface import GroundTruth
from warehouse_sim.estimators.pose.densefusion.objects import ShapeTensors
from warehouse_sim.estimators.pose.densefusion.settings import LossConfig, SymmetryLoss

# Keeps the square root differentiable at a perfect prediction and where two points coincide; 1e-4 of half a diameter.
_EPSILON = 1e-8


def equivalent_poses(gt: GroundTruth, shapes: ShapeTensors) -> tuple[Float[Tensor, "b g 3 3"], Float[Tensor, "b g 3"]]:
    """Return every pose that looks the same as the true one, in normalised units."""
    R_s, t_s = shapes.symmetry_rotation[gt.class_index], shapes.symmetry_translation[gt.class_index]
    rotations = gt.rotation[:, None] @ R_s
    return rotations, (gt.rotation[:, None] @ t_s[..., None])[..., 0] + gt.translation[:, None]


def pose_distance(
    rotation: Float[Tensor, "b n 3 3"],
    translation: Float[Tensor, "b n 3"],
    gt: GroundTruth,
    shapes: ShapeTensors,
    symmetry: SymmetryLoss = "group",
) -> Float[Tensor, "b n"]:
    """Return the surface distance of each predicted pose to the true one.

    Args:
        rotation: Predicted rotations.
        translation: Predicted object origins, normalised.
        gt: True poses.
        shapes: Shapes of the classes.
        symmetry: "group" and "shape" give the RMS distance to the nearest equivalent of the true pose; "none" to the
            true pose itself; "nearest" the mean distance of each surface point to the nearest one of the true pose for
            classes that are symmetric (ADD-S, as the original), and the RMS distance for the others.
    """
    with _in_32_bits(rotation):
        placed = _place(rotation, translation, gt.class_index, shapes)
        if symmetry in ("group", "shape"):
            return _rms(placed - _nearest_equivalent(placed, gt, shapes))
        gt_pose = gt.rotation[:, None], gt.translation[:, None]
        plain = _rms(placed - _place(*gt_pose, gt.class_index, shapes))
        if symmetry == "none":
            return plain
        symmetric = shapes.is_symmetric()[gt.class_index]
        return torch.where(symmetric[:, None], _nearest_point_distance(rotation, translation, gt, shapes), plain)


def loss_distance(
    rotation: Float[Tensor, "b n 3 3"],
    translation: Float[Tensor, "b n 3"],
    gt: GroundTruth,
    shapes: ShapeTensors,
    config: LossConfig,
) -> Float[Tensor, "b n"]:
    """Return the distance of each predicted pose to the true one that training minimises.

    Args:
        rotation: Predicted rotations.
        translation: Predicted object origins, normalised.
        gt: True poses.
        shapes: Shapes of the classes.
        config: Which distance, and its unit.
    """
    squared = config.distance == "chamfer-squared"
    if config.distance == "surface":
        found = pose_distance(rotation, translation, gt, shapes, config.symmetry)
    else:
        found = chamfer_distance(rotation, translation, gt, shapes, squared)
    if config.unit == "half-diameters":
        return found
    scale = shapes.half_diameter[gt.class_index][:, None]
    return found * (scale.square() if squared else scale)


def confidence_loss(
    distance: Float[Tensor, "b n"],
    logit: Float[Tensor, "b n"],
    weight: float,
    belongs: Bool[Tensor, "b n"] | None = None,
) -> Float[Tensor, ""]:
    """Return the mean of ``distance * c - weight * ln c`` with c = sigmoid(logit) (Wang et al. 2019, equation 3).

    Args:
        distance: Normalised pose distances.
        logit: Confidence before the sigmoid, so that ln c never meets a zero.
        weight: Distance up to which full confidence pays, normalised.
        belongs: Which of them count; None for all.
    """
    losses = distance * torch.sigmoid(logit) - weight * logsigmoid(logit)
    return losses.mean() if belongs is None else _mean_over(losses, belongs)


def inlier_loss(logit: Float[Tensor, "b n"], belongs: Bool[Tensor, "b n"]) -> Float[Tensor, ""]:
    """Return the mean binary cross-entropy of which points are the object's, both answers counting alike.

    Of a ground-truth mask nearly all points are the object's, of a box few: without balance the rare ones would hardly
    count.

    Args:
        logit: Trust in each point before the sigmoid.
        belongs: Which points are the object's.
    """
    losses = torch.nn.functional.binary_cross_entropy_with_logits(logit.float(), belongs.float(), reduction="none")
    return (_mean_over(losses, belongs) + _mean_over(losses, ~belongs)) / 2.0


def _mean_over(values: Float[Tensor, "b n"], mask: Bool[Tensor, "b n"]) -> Float[Tensor, ""]:
    return (values * mask).sum() / mask.sum().clamp(min=1)


def coordinate_loss(
    predicted: Float[Tensor, "b n 3"],
    log_scale: Float[Tensor, "b n"],
    points: Float[Tensor, "b n 3"],
    gt: GroundTruth,
    shapes: ShapeTensors,
    symmetry: SymmetryLoss = "group",
    belongs: Bool[Tensor, "b n"] | None = None,
) -> Float[Tensor, ""]:
    """Return the mean negative log-likelihood of object coordinates, constants left out.

    The error of a point is Laplace distributed, p(e) ~ exp(-|e| / b) / b^3. Each object is compared with that
    equivalent of its true pose that explains its points best, all points with the same.

    Args:
        predicted: Coordinates in the object's frame, normalised.
        log_scale: ln b of each point.
        points: The measured points that they belong to, normalised.
        gt: True poses.
        shapes: Shapes of the classes.
        symmetry: "none" compares with the true pose only.
        belongs: Which points are the object's, and count; None for all.
    """
    with _in_32_bits(points):
        if symmetry == "none":
            rotations, translations = gt.rotation[:, None], gt.translation[:, None]
        else:
            rotations, translations = equivalent_poses(gt, shapes)
        # R^T (p - t), for each equivalent pose.
        wanted = (points.float()[:, None] - translations[:, :, None]) @ rotations
        error = ((predicted[:, None] - wanted).square().sum(dim=-1) + _EPSILON).sqrt()
        log_scale = log_scale[:, None]
        losses = error * torch.exp(-log_scale) + 3.0 * log_scale
        if belongs is None:
            return losses.mean(dim=-1).amin(dim=1).mean()
        counts = belongs[:, None]
        return ((losses * counts).sum(dim=-1) / counts.sum(dim=-1).clamp(min=1)).amin(dim=1).mean()


def _in_32_bits(tensor: Tensor) -> torch.autocast:
    """Keep mixed precision out: in 16 bits a pose is off by millimetres."""
    return torch.autocast(tensor.device.type, enabled=False)


def _nearest_equivalent(
    placed: Float[Tensor, "b n 12"], gt: GroundTruth, shapes: ShapeTensors
) -> Float[Tensor, "b n 12"]:
    """Return, for each pose, the anchors under that equivalent of the true pose which is nearest to it."""
    wanted = _place(*equivalent_poses(gt, shapes), gt.class_index, shapes)
    with torch.no_grad():
        # |a - b|^2 = |a|^2 - 2 a.b + |b|^2: one product finds the nearest, whose distance is then computed exactly.
        cross = torch.bmm(placed, wanted.mT)
        nearest = (wanted.square().sum(dim=-1)[:, None] - 2.0 * cross).argmin(dim=-1)
    return torch.gather(wanted, 1, nearest[..., None].expand(-1, -1, wanted.shape[-1]))


def _rms(difference: Float[Tensor, "b n a"]) -> Float[Tensor, "b n"]:
    # Four anchors of three values each: the mean over anchors of the sum over axes.
    return (difference.square().sum(dim=-1) / 4.0 + _EPSILON).sqrt()


def _place(
    rotation: Float[Tensor, "b n 3 3"],
    translation: Float[Tensor, "b n 3"],
    class_index: Int[Tensor, " b"],
    shapes: ShapeTensors,
) -> Float[Tensor, "b n 12"]:
    """Return the classes' anchors under each pose, their coordinates in one row."""
    anchors = shapes.anchors[class_index].mT[:, None]
    return (rotation @ anchors + translation[..., None]).flatten(2)


def _nearest_point_distance(
    rotation: Float[Tensor, "b n 3 3"], translation: Float[Tensor, "b n 3"], gt: GroundTruth, shapes: ShapeTensors
) -> Float[Tensor, "b n"]:
    predicted, wanted, far = _surfaces(rotation, translation, gt, shapes)
    return _apart(predicted, _rows(wanted, far.argmin(dim=3)), squared=False).mean(dim=-1)


def chamfer_distance(
    rotation: Float[Tensor, "b n 3 3"],
    translation: Float[Tensor, "b n 3"],
    gt: GroundTruth,
    shapes: ShapeTensors,
    squared: bool,
) -> Float[Tensor, "b n"]:
    """Return the Chamfer distance of each predicted pose to the true one, in half diameters, or their squares.

    Mean over the predicted points of the distance to the nearest true one, plus mean over the true points of the
    distance to the nearest predicted one (Fan et al., "A Point Set Generation Network", CVPR 2017, with squares). Both
    sides are the same points of the surface, as in the dissertation, whose model of an object is the true cloud itself:
    the true pose costs nothing, and so does each that maps these points onto each other.

    Args:
        rotation: Predicted rotations.
        translation: Predicted object origins, normalised.
        gt: True poses.
        shapes: Shapes of the classes, with points of their surfaces.
        squared: Whether distances are squared before the mean.
    """
    with _in_32_bits(rotation):
        predicted, wanted, far = _surfaces(rotation.float(), translation.float(), gt, shapes)
        there = _apart(predicted, _rows(wanted, far.argmin(dim=3)), squared)
        back = _apart(wanted, _rows(predicted, far.argmin(dim=2)), squared)
        return there.mean(dim=-1) + back.mean(dim=-1)


def _surfaces(
    rotation: Float[Tensor, "b n 3 3"], translation: Float[Tensor, "b n 3"], gt: GroundTruth, shapes: ShapeTensors
) -> tuple[Float[Tensor, "b n m 3"], Float[Tensor, "b n m 3"], Float[Tensor, "b n m m"]]:
    """Return the surface's points in each pose and in the true one, and how far these are from each other."""
    surface = shapes.surface[gt.class_index]
    predicted = torch.einsum("bnij,bmj->bnmi", rotation, surface) + translation[:, :, None]
    wanted = surface @ gt.rotation.mT + gt.translation[:, None]
    with torch.no_grad():
        # Not by matrix products: their differences of squares lose the small distances.
        far = torch.cdist(predicted.flatten(1, 2), wanted, compute_mode="donot_use_mm_for_euclid_dist")
    far = far.view(*predicted.shape[:3], wanted.shape[1])
    return predicted, wanted[:, None].expand(-1, predicted.shape[1], -1, -1), far


def _rows(points: Float[Tensor, "b n m 3"], index: Tensor) -> Float[Tensor, "b n m 3"]:
    return torch.gather(points, 2, index[..., None].expand(-1, -1, -1, 3))


def _apart(a: Float[Tensor, "b n m 3"], b: Float[Tensor, "b n m 3"], squared: bool) -> Float[Tensor, "b n m"]:
    square = (a - b).square().sum(dim=-1)
    return square if squared else (square + _EPSILON).sqrt()
