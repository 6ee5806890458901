"""Choose one pose from the many that the points of an object propose, for all objects of a batch at once."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.geometry.pose import Transforms, make_transform, matrix_from_quat_wxyz, quat_wxyz_from_matrix
from warehouse_sim.geometry.symmetry import SymmetryGroup

Selection = Literal["argmax", "weighted", "weighted-50", "consensus"]

# Poses that agree with the most confident one: within 8 degrees and 4 % of the diameter.
_AGREE_ANGLE = np.deg2rad(8.0)
_AGREE_FRACTION = 0.04


@dataclass(frozen=True, eq=False)
class Candidates:
    """The poses that are proposed for b objects, m each, in the camera frame."""

    quat_wxyz: Float[np.ndarray, "b m 4"]
    """Rotations as unit quaternions of either sign."""
    translation: Float[np.ndarray, "b m 3"]
    """Object origins (m)."""
    confidence: Float[np.ndarray, "b m"]
    """Trust in each, 0-1."""

    def __post_init__(self) -> None:
        length = np.linalg.norm(self.quat_wxyz, axis=-1, keepdims=True)
        object.__setattr__(self, "quat_wxyz", self.quat_wxyz / np.maximum(length, 1e-12))


@dataclass(frozen=True, eq=False)
class Symmetries:
    """The symmetry groups of b objects, filled up with the identity to the size of the largest."""

    quat_wxyz: Float[np.ndarray, "b g 4"]
    translation: Float[np.ndarray, "b g 3"]
    """Metres."""

    @classmethod
    def of(cls, groups: Sequence[SymmetryGroup]) -> "Symmetries":
        """Stack the groups."""
        most = max(len(group) for group in groups)
        quat, translation = np.zeros((len(groups), most, 4)), np.zeros((len(groups), most, 3))
        quat[..., 0] = 1.0
        for row, group in enumerate(groups):
            quat[row, : len(group)] = [quat_wxyz_from_matrix(T[:3, :3]) for T in group.transforms]
            translation[row, : len(group)] = group.transforms[:, :3, 3]
        return cls(quat, translation)

    def rows(self, index: Sequence[int]) -> "Symmetries":
        """Return the groups of the objects ``index``."""
        return Symmetries(self.quat_wxyz[index], self.translation[index])


def select_poses(
    candidates: Candidates, symmetries: Symmetries, diameters: Float[np.ndarray, " b"], method: Selection
) -> Transforms:
    """Return one ``T_camera_object`` for each object, (b 4 4).

    Args:
        candidates: The proposed poses.
        symmetries: Of the objects; poses that look the same are averaged as one.
        diameters: Of the objects (m).
        method: "argmax" takes the most confident; "weighted" averages all by confidence, "weighted-50" the more
            confident half, "consensus" those that agree with the most confident.
    """
    rows, best = np.arange(len(candidates.confidence)), candidates.confidence.argmax(axis=1)
    if method == "argmax":
        rotation = matrix_from_quat_wxyz(candidates.quat_wxyz[rows, best])
        return make_transform(rotation, candidates.translation[rows, best])
    aligned = align_to(best, candidates, symmetries)
    if method == "weighted-50":
        chosen = aligned.confidence >= np.median(aligned.confidence, axis=1, keepdims=True)
    elif method == "consensus":
        chosen = _agreeing(aligned, best, diameters)
    else:
        chosen = np.ones(aligned.confidence.shape, dtype=bool)
    weights = np.where(chosen, aligned.confidence, 0.0)
    # A network that has not learned can give all of them a confidence that is too small for a float.
    return average_poses(aligned, np.where(weights.sum(axis=1, keepdims=True) > 0.0, weights, chosen))


def align_to(best: Sequence[int], candidates: Candidates, symmetries: Symmetries) -> Candidates:
    """Replace each pose by its symmetric equivalent that is turned least against pose number ``best`` of its object."""
    quat, reference = candidates.quat_wxyz, candidates.quat_wxyz[np.arange(len(best)), best]
    equivalents = _product(quat[:, :, None], symmetries.quat_wxyz[:, None])
    nearest = np.abs(np.einsum("bmgi,bi->bmg", equivalents, reference)).argmax(axis=2)[..., None]
    turned = np.take_along_axis(equivalents, nearest[..., None], axis=2)[:, :, 0]
    shift = np.take_along_axis(symmetries.translation, nearest, axis=1)
    if shift.any():
        shift = np.einsum("bmij,bmj->bmi", matrix_from_quat_wxyz(quat), shift)
    return Candidates(turned, candidates.translation + shift, candidates.confidence)


def average_poses(candidates: Candidates, weights: Float[np.ndarray, "b m"]) -> Transforms:
    """Return the weighted mean pose of each object, (b 4 4).

    The mean rotation is the eigenvector of the weighted sum of q q^T with the *largest* eigenvalue (Markley et al.,
    "Averaging quaternions", J. Guidance 30(4), 2007), which does not see the sign of a quaternion. ``eigh`` sorts its
    eigenvalues, unlike ``eig``.
    """
    fraction = weights / weights.sum(axis=1, keepdims=True)
    quat = candidates.quat_wxyz
    matrix = (quat * fraction[..., None]).swapaxes(1, 2) @ quat
    principal = np.linalg.eigh(matrix)[1][..., -1]
    translation = np.einsum("bm,bmi->bi", fraction, candidates.translation)
    return make_transform(matrix_from_quat_wxyz(principal), translation)


def _agreeing(aligned: Candidates, best: Sequence[int], diameters: Float[np.ndarray, " b"]) -> Bool[np.ndarray, "b m"]:
    rows = np.arange(len(best))
    away = np.linalg.norm(aligned.translation - aligned.translation[rows, best][:, None], axis=2)
    cosine = np.abs(np.einsum("bmi,bi->bm", aligned.quat_wxyz, aligned.quat_wxyz[rows, best]))
    return (away <= _AGREE_FRACTION * diameters[:, None]) & (cosine >= np.cos(_AGREE_ANGLE / 2.0))


def _product(a: Float[np.ndarray, "*batch 4"], b: Float[np.ndarray, "*batch 4"]) -> Float[np.ndarray, "*batch 4"]:
    """Return Hamilton products, which turn by ``b`` first."""
    w, x, y, z = np.moveaxis(a, -1, 0)
    p, q, r, s = np.moveaxis(b, -1, 0)
    parts = (
        w * p - x * q - y * r - z * s,
        w * q + x * p + y * s - z * r,
        w * r - x * s + y * p + z * q,
        w * s + x * r - y * q + z * p,
    )
    return np.stack(parts, axis=-1)
