"""Pose errors up to symmetry: ADD, ADD-S, MSSD, MSPD, rotation and translation.

Everything is computed from ``T_object_estimated``, the place that an estimate gives to the object as seen from the true
object: the identity for a perfect estimate. Lengths do not depend on the frame, and numbers near the origin keep the
digits that a camera frame ten metres away would lose.
"""

import numpy as np
from jaxtyping import Float, Int
from scipy.spatial import KDTree

from warehouse_sim.evaluation.blocks import in_blocks
from warehouse_sim.geometry.pose import Transforms, invert, rotation_angle, transform_points
from warehouse_sim.geometry.symmetry import SymmetryGroup

_BLOCK = 512
"""Transforms handled at once, which bounds memory for large symmetry groups."""
_AT_ONCE = 50_000
"""Points handled at once, few enough for the processor's cache."""


def estimates_in_object(
    T_camera_estimated: Transforms, T_camera_object: Transforms, symmetry: SymmetryGroup
) -> Transforms:
    """Return ``T_object_estimated`` for every way to name the object's look-alike poses.

    Args:
        T_camera_estimated: Estimated poses, "*batch 4 4".
        T_camera_object: True poses, "*batch 4 4".
        symmetry: Group of s motions of the object frame that leave its look unchanged.

    Returns:
        ``inv(T_camera_object) @ T_camera_estimated @ S``, "*batch s 4 4"; all s are equally right answers.
    """
    T_object_estimated = invert(T_camera_object) @ T_camera_estimated
    return T_object_estimated[..., None, :, :] @ symmetry.transforms


def add(T_object_estimated: Transforms, points: Float[np.ndarray, "m 3"]) -> Float[np.ndarray, "*batch"]:
    """Return the mean distance (m) between a point and its estimated place.

    Hinterstoisser et al., ACCV 2012, equation 7. The minimum of the result over the symmetry axis is the
    symmetry-aware ADD, which, unlike ADD-S, does not forgive a pallet that lies upside down.

    Args:
        T_object_estimated: "*batch 4 4".
        points: Surface points in the object frame (m).
    """
    flat = T_object_estimated.reshape(-1, 4, 4)
    terms, result = _terms(points), np.empty(len(flat))

    def work(part: slice) -> None:
        squared = _weights(flat[part]) @ terms
        result[part] = np.sqrt(np.maximum(squared, 0.0, out=squared), out=squared).mean(axis=-1)

    in_blocks(len(flat), _BLOCK, work)
    return result.reshape(T_object_estimated.shape[:-2])


def surface_rms(T_object_estimated: Transforms, points: Float[np.ndarray, "m 3"]) -> Float[np.ndarray, "*batch"]:
    """Return the root of the mean squared distance (m) between a point and its estimated place.

    Args:
        T_object_estimated: "*batch 4 4".
        points: Surface points in the object frame (m).
    """
    flat = T_object_estimated.reshape(-1, 4, 4)
    squared = _weights(flat) @ _terms(points).mean(axis=1)
    return np.sqrt(np.maximum(squared, 0.0)).reshape(T_object_estimated.shape[:-2])


def mssd(T_object_estimated: Transforms, points: Float[np.ndarray, "m 3"]) -> Float[np.ndarray, "*batch"]:
    """Return the largest distance (m) between a point and its estimated place.

    The minimum of the result over the symmetry axis is the maximum symmetry-aware surface distance of Hodan et al., BOP
    Challenge 2020, section 2.2. The distance is a convex function of the point, so the corners of the convex hull give
    the exact maximum over the whole solid.

    Args:
        T_object_estimated: "*batch 4 4".
        points: Corners of the object's convex hull (or any surface points) in the object frame (m).
    """
    flat = T_object_estimated.reshape(-1, 4, 4)
    result = np.empty(len(flat))
    for start in range(0, len(flat), _BLOCK):
        moved = transform_points(flat[start : start + _BLOCK], points)
        result[start : start + _BLOCK] = np.linalg.norm(moved - points, axis=-1).max(axis=-1)
    return result.reshape(T_object_estimated.shape[:-2])


def add_s(
    T_object_estimated: Transforms, points: Float[np.ndarray, "m 3"], tree: KDTree
) -> Float[np.ndarray, "*batch"]:
    """Return the mean distance (m) from each true point to the nearest estimated point.

    The direction is that of Hinterstoisser et al. (ADI) and of PoseCNN: over ground-truth-posed points, nearest among
    estimate-posed ones. A legacy score: for a pallet it forgives nearly every turn.

    Args:
        T_object_estimated: "*batch 4 4", without a symmetry axis, which would change nothing.
        points: Surface points in the object frame (m).
        tree: ``KDTree(points)``.
    """
    # The estimate is rigid: asking the resting points for their distance to x, moved back, needs one tree for all.
    moved_back = invert(T_object_estimated).reshape(-1, 4, 4)
    result = np.empty(len(moved_back))

    def work(block: slice) -> None:
        distance, _ = tree.query(transform_points(moved_back[block], points))
        result[block] = np.asarray(distance).mean(axis=-1)

    in_blocks(len(result), _AT_ONCE // len(points), work)
    return result.reshape(T_object_estimated.shape[:-2])


def chamfer(
    T_object_estimated: Transforms, points: Float[np.ndarray, "m 3"], tree: KDTree
) -> Float[np.ndarray, "*batch"]:
    """Return the Chamfer distance (m): ``add_s`` both ways, from true to estimated points and back, halved.

    Fan, Su and Guibas, CVPR 2017, equation 1, with distances that are not squared and with means, so that it compares
    with the other lengths. It forgives all that ``add_s`` forgives; no score rests on it.

    Args:
        T_object_estimated: "*batch 4 4", without a symmetry axis.
        points: Surface points in the object frame (m).
        tree: ``KDTree(points)``.
    """
    return (add_s(T_object_estimated, points, tree) + add_s(invert(T_object_estimated), points, tree)) / 2.0


def rotation_error(T_object_estimated: Transforms) -> Float[np.ndarray, "*batch"]:
    """Return the angle (rad) of the rotation between true and estimated pose."""
    return rotation_angle(T_object_estimated[..., :3, :3], np.eye(3))


def translation_error(T_object_estimated: Transforms) -> Float[np.ndarray, "*batch"]:
    """Return the distance (m) between true and estimated object origin."""
    return np.linalg.norm(T_object_estimated[..., :3, 3], axis=-1)


def nearest_symmetry(
    T_object_estimated: Transforms, points: Float[np.ndarray, "m 3"]
) -> tuple[Transforms, Int[np.ndarray, "*batch"]]:
    """Choose the symmetry under which an estimate comes closest to the ground truth, by MSSD.

    Args:
        T_object_estimated: "*batch s 4 4" from ``estimates_in_object``.
        points: Corners of the object's convex hull (m).

    Returns:
        The chosen "*batch 4 4", and the index of the chosen symmetry.
    """
    best = np.argmin(mssd(T_object_estimated, points), axis=-1)
    return np.take_along_axis(T_object_estimated, best[..., None, None, None], axis=-3)[..., 0, :, :], best


def _weights(T_object_estimated: Transforms) -> Float[np.ndarray, "k 10"]:
    """Return what the ``_terms`` of a point are multiplied with to give its squared distance from its estimated place.

    With M = R - I and p a point, that is |M p + t|^2 = p^T M^T M p + 2 (M^T t) p + t^T t. For a good estimate each term
    is small, so that no digits are lost; and one product of matrices serves all points.
    """
    M, t = T_object_estimated[:, :3, :3] - np.eye(3), T_object_estimated[:, :3, 3]
    A, b = np.swapaxes(M, 1, 2) @ M, np.einsum("kji,kj->ki", M, t)
    row, column = np.triu_indices(3)
    quadratic = np.where(row == column, 1.0, 2.0) * A[:, row, column]
    return np.concatenate([quadratic, 2.0 * b, np.einsum("ki,ki->k", t, t)[:, None]], axis=1)


def _terms(points: Float[np.ndarray, "m 3"]) -> Float[np.ndarray, "10 m"]:
    """Return products of coordinates in the order of ``_weights``."""
    row, column = np.triu_indices(3)
    return np.concatenate([(points[:, row] * points[:, column]).T, points.T, np.ones((1, len(points)))])


def mspd(
    T_camera_estimated: Transforms,
    T_camera_object: Transforms,
    symmetry: SymmetryGroup,
    K: Float[np.ndarray, "n 3 3"],
    points: Float[np.ndarray, "m 3"],
) -> Float[np.ndarray, " n"]:
    """Return the maximum symmetry-aware projection distance (px).

    Hodan et al., BOP Challenge 2020 (ECCVW 2020), section 2.2: the largest distance between the projections of a point
    in the estimated and in the true pose, smallest over the symmetries. Unlike that of a distance in space, the largest
    one need not be at a corner of the convex hull, so all points are projected.

    Args:
        T_camera_estimated: Estimates, "n 4 4".
        T_camera_object: True poses, "n 4 4".
        symmetry: Of the object.
        K: Intrinsics of the image of each.
        points: Of the model, in the object frame (m).
    """
    homogeneous = np.concatenate([points.T, np.ones((1, len(points)))])
    result = np.full(len(T_camera_estimated), np.inf)

    def work(block: slice) -> None:
        estimated = _projected(K[block] @ T_camera_estimated[block, :3], homogeneous)
        for S in symmetry.transforms:
            apart = estimated - _projected(K[block] @ (T_camera_object[block] @ S)[:, :3], homogeneous)
            largest = np.sqrt((apart * apart).sum(axis=1).max(axis=1))
            result[block] = np.minimum(result[block], largest)

    in_blocks(len(result), _AT_ONCE // len(points), work)
    return result


def _projected(P: Float[np.ndarray, "n 3 4"], homogeneous: Float[np.ndarray, "4 m"]) -> Float[np.ndarray, "n 2 m"]:
    uvw = P @ homogeneous
    return uvw[:, :2] / uvw[:, 2:]
