"""How far the poses that a network proposes agree with the one that came out."""

import numpy as np

from warehouse_sim.estimators.pose.choose import Candidates, Symmetries, align_to
from warehouse_sim.geometry.pose import Transforms, quat_wxyz_from_matrix
from warehouse_sim.schema import Agreement


def agreement(candidates: Candidates, symmetries: Symmetries, T_camera_object: Transforms) -> list[Agreement]:
    """Return what b x m proposals say of b estimates.

    Args:
        candidates: The proposals.
        symmetries: Of the objects; a proposal counts as its equivalent that is nearest to the estimate.
        T_camera_object: The estimates, (b 4 4).
    """
    quat = np.stack([quat_wxyz_from_matrix(T[:3, :3]) for T in T_camera_object])
    most = candidates.confidence.shape[1]
    joined = Candidates(
        np.concatenate([candidates.quat_wxyz, quat[:, None]], axis=1),
        np.concatenate([candidates.translation, T_camera_object[:, None, :3, 3]], axis=1),
        np.concatenate([candidates.confidence, np.zeros((len(quat), 1))], axis=1),
    )
    aligned = align_to([most] * len(quat), joined, symmetries)
    weight = candidates.confidence + 1e-9
    weight = weight / weight.sum(axis=1, keepdims=True)
    place = aligned.translation[:, :most]
    middle = (weight[..., None] * place).sum(axis=1)
    spread = np.sqrt((weight * ((place - middle[:, None]) ** 2).sum(axis=2)).sum(axis=1))
    cosine = np.clip(np.abs(np.einsum("bmi,bi->bm", aligned.quat_wxyz[:, :most], quat)), 0.0, 1.0)
    turn = np.sqrt((weight * (2.0 * np.arccos(cosine)) ** 2).sum(axis=1))
    moved = np.linalg.norm(middle - T_camera_object[:, :3, 3], axis=1)
    return [Agreement(*map(float, row)) for row in zip(spread, turn, moved, strict=True)]
