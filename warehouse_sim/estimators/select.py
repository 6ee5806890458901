"""Choose one pose from the many that the points of an object propose."""

from typing import Literal

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.pose import (
    Transform,
    make_transform,
    matrix_from_quat_wxyz,
    quat_wxyz_from_matrix,
    rotation_angle,
)
from warehouse_sim.geometry.symmetry import SymmetryGroup

Selection = Literal["argmax", "wavg", "wavg50", "consensus"]

# Poses that agree with the most confident one: within 8 degrees and 4 % of the diameter.
_AGREE_ANGLE = np.deg2rad(8.0)
_AGREE_SHARE = 0.04


def select_pose(
    rotations: Float[np.ndarray, "n 3 3"],
    translations: Float[np.ndarray, "n 3"],
    confidences: Float[np.ndarray, " n"],
    symmetry: SymmetryGroup,
    diameter: float,
    method: Selection,
) -> Transform:
    """Return one ``T_camera_object``.

    Args:
        rotations: Proposed rotations.
        translations: Proposed object origins in the camera frame (m).
        confidences: Trust in each, 0-1.
        symmetry: Group of the object; poses that look the same are averaged as one.
        diameter: Of the object (m).
        method: "argmax" takes the most confident; "wavg" averages all by confidence, "wavg50" the more confident
            half, "consensus" those that agree with the most confident.
    """
    best = int(np.argmax(confidences))
    if method == "argmax":
        return make_transform(rotations[best], translations[best])
    rotations, translations = align_to(best, rotations, translations, symmetry)
    if method == "wavg50":
        chosen = confidences >= np.median(confidences)
    elif method == "consensus":
        near = np.linalg.norm(translations - translations[best], axis=1) <= _AGREE_SHARE * diameter
        chosen = near & (rotation_angle(rotations, rotations[best]) <= _AGREE_ANGLE)
    else:
        chosen = np.ones(len(confidences), dtype=bool)
    return average_pose(rotations[chosen], translations[chosen], confidences[chosen])


def align_to(
    best: int,
    rotations: Float[np.ndarray, "n 3 3"],
    translations: Float[np.ndarray, "n 3"],
    symmetry: SymmetryGroup,
) -> tuple[Float[np.ndarray, "n 3 3"], Float[np.ndarray, "n 3"]]:
    """Replace each pose by its symmetric equivalent that is turned least against pose number ``best``."""
    equivalents = make_transform(rotations, translations)[:, None] @ symmetry.transforms
    nearest = rotation_angle(equivalents[..., :3, :3], rotations[best]).argmin(axis=1)
    chosen = equivalents[np.arange(len(rotations)), nearest]
    return chosen[:, :3, :3], chosen[:, :3, 3]


def average_pose(
    rotations: Float[np.ndarray, "n 3 3"], translations: Float[np.ndarray, "n 3"], weights: Float[np.ndarray, " n"]
) -> Transform:
    """Return the weighted mean pose.

    The mean rotation is the principal eigenvector of M, the weighted mean of q q^T (Markley et al., "Averaging
    quaternions", J. Guidance 30(4), 2007), which does not see the sign of a quaternion. Bar-Itzhack's matrix of a
    rotation is 4 q q^T - I and linear in the rotation, so that of the mean rotation matrix is 4 M - I.
    """
    share = weights / weights.sum()
    quat_wxyz = quat_wxyz_from_matrix(np.einsum("n,nij->ij", share, rotations))
    return make_transform(matrix_from_quat_wxyz(quat_wxyz), share @ translations)
