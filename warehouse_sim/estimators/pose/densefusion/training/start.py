"""Start a network at the mean pose of its training data, where every sample is nearest."""

import numpy as np
import torch
from jaxtyping import Float

from warehouse_sim.estimators.pose.densefusion.crops import CropSet
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusion
from warehouse_sim.estimators.pose.densefusion.objects import ObjectShape
from warehouse_sim.geometry.pose import matrix_from_quat_wxyz, quat_wxyz_from_matrix

_ROUNDS = 5


def start_at_mean_rotation(network: DenseFusion, crops: CropSet, shapes: tuple[ObjectShape, ...]) -> None:
    """Make ``network`` propose about the mean rotation of each class of which there are crops.

    From an arbitrary start the two looks of a half-turn symmetry are about equally far, samples choose different
    ones, and the network first has to agree with itself.
    """
    for number, shape in enumerate(shapes):
        rotations = crops.T_camera_object[crops.class_index == number, :3, :3].cpu().numpy()
        if len(rotations) == 0:
            continue
        symmetries = np.reshape(shape.symmetries, (-1, 4, 4))[:, :3, :3]
        quat = torch.from_numpy(mean_quat_wxyz(rotations, symmetries))
        network.heads.start_rotation(number, quat)


def mean_quat_wxyz(
    rotations: Float[np.ndarray, "k 3 3"], symmetries: Float[np.ndarray, "g 3 3"]
) -> Float[np.ndarray, " 4"]:
    """Return the mean of ``rotations``, each replaced by the symmetric equivalent nearest to that mean.

    Args:
        rotations: At least one.
        symmetries: Rotations of the object's symmetry group.
    """
    equivalents = rotations[:, None] @ symmetries
    mean = rotations[0]
    for _ in range(_ROUNDS):
        nearest = np.einsum("kgij,ij->kg", equivalents, mean).argmax(axis=1)
        aligned = equivalents[np.arange(len(rotations)), nearest]
        # Markley's mean: the eigenvector is linear in the rotation matrices.
        quat = quat_wxyz_from_matrix(aligned.mean(axis=0))
        mean = matrix_from_quat_wxyz(quat)
    return quat
