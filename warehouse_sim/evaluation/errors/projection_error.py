"""MSPD: how far the surface lies from its true place in the image, whatever its distance says."""

import numpy as np
from jaxtyping import Float

from warehouse_sim.evaluation.blocks import in_blocks
from warehouse_sim.geometry.pose import Transforms
from warehouse_sim.geometry.symmetry import SymmetryGroup

_AT_ONCE = 50_000
"""Points projected at once, few enough for the processor's cache."""


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
