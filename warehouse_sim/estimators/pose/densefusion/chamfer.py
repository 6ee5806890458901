"""Chamfer distance between an object's surface under predicted poses and under the true one."""

import torch
from jaxtyping import Float
from torch import Tensor

from warehouse_sim.estimators.pose.densefusion.networks.inputs import GroundTruth
from warehouse_sim.estimators.pose.densefusion.objects import ShapeTensors

# Keeps the square root differentiable where two points coincide; 1e-4 of half a diameter.
_EPSILON = 1e-8


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
    with torch.autocast(rotation.device.type, enabled=False):
        surface = shapes.surface[gt.class_index]
        predicted = torch.einsum("bnij,bmj->bnmi", rotation.float(), surface) + translation.float()[:, :, None]
        wanted = surface @ gt.rotation.mT + gt.translation[:, None]
        with torch.no_grad():
            # Not by matrix products: their differences of squares lose the small distances.
            far = torch.cdist(predicted.flatten(1, 2), wanted, compute_mode="donot_use_mm_for_euclid_dist")
            far = far.view(*predicted.shape[:3], wanted.shape[1])
            of_predicted, of_true = far.argmin(dim=3), far.argmin(dim=2)
        wanted = wanted[:, None].expand(-1, predicted.shape[1], -1, -1)
        there = _apart(predicted, _rows(wanted, of_predicted), squared)
        back = _apart(wanted, _rows(predicted, of_true), squared)
        return there.mean(dim=-1) + back.mean(dim=-1)


def _rows(points: Float[Tensor, "b n m 3"], index: Tensor) -> Float[Tensor, "b n m 3"]:
    return torch.gather(points, 2, index[..., None].expand(-1, -1, -1, 3))


def _apart(a: Float[Tensor, "b n m 3"], b: Float[Tensor, "b n m 3"], squared: bool) -> Float[Tensor, "b n m"]:
    square = (a - b).square().sum(dim=-1)
    return square if squared else (square + _EPSILON).sqrt()
