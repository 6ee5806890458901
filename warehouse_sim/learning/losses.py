"""Losses between predicted and true poses, in normalised units and over each object's symmetry group.

The distance of two poses is the RMS distance of the model's surface points. It depends on the surface through its mean
and covariance only, so four anchor points with the same moments give it exactly, and the minimum over a finite group
costs little.
"""

import torch
from jaxtyping import Float, Int
from torch import Tensor
from torch.nn.functional import logsigmoid

from warehouse_sim.learning.networks.heads import Hypotheses
from warehouse_sim.learning.objects import ShapeTensors
from warehouse_sim.learning.rotations import matrix_from_quat_wxyz

# Keeps the square root differentiable at a perfect prediction; 1e-4 of half a diameter.
_EPSILON = 1e-8


def equivalent_poses(
    rotation: Float[Tensor, "b 3 3"],
    translation: Float[Tensor, "b 3"],
    class_index: Int[Tensor, " b"],
    shapes: ShapeTensors,
) -> tuple[Float[Tensor, "b g 3 3"], Float[Tensor, "b g 3"]]:
    """Return every pose that looks the same as the given one, in normalised units."""
    R_s, t_s = shapes.symmetry_rotation[class_index], shapes.symmetry_translation[class_index]
    rotations = rotation[:, None] @ R_s
    return rotations, (rotation[:, None] @ t_s[..., None])[..., 0] + translation[:, None]


def pose_distance(
    rotation: Float[Tensor, "b n 3 3"],
    translation: Float[Tensor, "b n 3"],
    true_rotation: Float[Tensor, "b 3 3"],
    true_translation: Float[Tensor, "b 3"],
    class_index: Int[Tensor, " b"],
    shapes: ShapeTensors,
) -> Float[Tensor, "b n"]:
    """Return the RMS surface distance of each predicted pose to the nearest equivalent of the true one."""
    anchors = shapes.anchors[class_index]
    R_true, t_true = equivalent_poses(true_rotation, true_translation, class_index, shapes)
    predicted = torch.einsum("bnij,bkj->bnik", rotation, anchors) + translation[..., None]
    wanted = torch.einsum("bgij,bkj->bgik", R_true, anchors) + t_true[..., None]
    squared = (predicted[:, :, None] - wanted[:, None]).square().sum(dim=-2).mean(dim=-1)
    return (squared.amin(dim=2) + _EPSILON).sqrt()


def confidence_loss(distance: Float[Tensor, "b n"], logit: Float[Tensor, "b n"], weight: float) -> Float[Tensor, ""]:
    """Return the mean of ``distance * c - weight * ln c`` with c = sigmoid(logit) (Wang et al. 2019, equation 3).

    Args:
        distance: Normalised pose distances.
        logit: Confidence before the sigmoid, so that ln c never meets a zero.
        weight: Distance up to which full confidence pays, normalised.
    """
    return (distance * torch.sigmoid(logit) - weight * logsigmoid(logit)).mean()


def hypotheses_distance(
    hypotheses: Hypotheses,
    true_rotation: Float[Tensor, "b 3 3"],
    true_translation: Float[Tensor, "b 3"],
    class_index: Int[Tensor, " b"],
    shapes: ShapeTensors,
) -> Float[Tensor, "b n"]:
    """Return the normalised distance of each point's pose."""
    rotation = matrix_from_quat_wxyz(hypotheses.quat_wxyz)
    return pose_distance(rotation, hypotheses.translation, true_rotation, true_translation, class_index, shapes)


def refined_distance(
    rotation: Float[Tensor, "b 3 3"],
    translation: Float[Tensor, "b 3"],
    true_rotation: Float[Tensor, "b 3 3"],
    true_translation: Float[Tensor, "b 3"],
    class_index: Int[Tensor, " b"],
    shapes: ShapeTensors,
) -> Float[Tensor, " b"]:
    """Return the normalised distance of one pose an object; its mean is the refiner's loss."""
    poses = rotation[:, None], translation[:, None]
    return pose_distance(*poses, true_rotation, true_translation, class_index, shapes)[:, 0]
