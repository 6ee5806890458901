"""Where prims stand: translation and orientation in double precision, as simulators move them, and a scale."""

from typing import Any

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.pose import Transform, make_transform, quat_wxyz_from_matrix
from warehouse_sim.interchange.usd.bindings import bindings

_SCALE = "xformOp:scale"


def place(prim: Any, T_parent_prim: Transform, scale: Float[np.ndarray, " 3"] | None = None) -> None:
    """Give a prim its pose in its parent.

    The three ops are those that Isaac Sim sets (docs.isaacsim.omniverse.nvidia.com, "XFormPrim": translate, orient,
    scale), so that moving the prim there keeps what stands here.

    Args:
        prim: What to place.
        T_parent_prim: Its pose, rigid.
        scale: Factors along its own axes; None = none.
    """
    pxr = bindings()
    double = pxr.Geom.XformOp.PrecisionDouble
    xform = pxr.Geom.Xformable(prim)
    xform.AddTranslateOp(double).Set(pxr.Gf.Vec3d(*map(float, T_parent_prim[:3, 3])))
    w, x, y, z = map(float, quat_wxyz_from_matrix(T_parent_prim[:3, :3]))
    xform.AddOrientOp(double).Set(pxr.Gf.Quatd(w, x, y, z))
    if scale is not None:
        xform.AddScaleOp(double).Set(pxr.Gf.Vec3d(*map(float, scale)))


def placed_at(prim: Any) -> tuple[Transform, Float[np.ndarray, " 3"]]:
    """Return pose and scale of a prim in its parent, by whatever ops another program has given it."""
    pxr = bindings()
    xform = pxr.Geom.Xformable(prim)
    # USD multiplies row vectors from the left, so its matrices are the transpose of ours.
    matrix = np.array(xform.GetLocalTransformation(pxr.Usd.TimeCode.Default())).T
    operations = [str(item.GetOpName()) for item in xform.GetOrderedXformOps()]
    if _SCALE not in operations:
        scale = np.ones(3)
    elif operations[-1] == _SCALE:
        scale = np.array(prim.GetAttribute(_SCALE).Get(), float)
    else:
        scale = np.linalg.norm(matrix[:3, :3], axis=0)
    return make_transform(matrix[:3, :3] / scale, matrix[:3, 3]), scale


def world_pose(cache: Any, prim: Any) -> Transform:
    """Return the pose of a prim in the world from a ``UsdGeom.XformCache``."""
    matrix = np.array(cache.GetLocalToWorldTransform(prim)).T
    return make_transform(matrix[:3, :3] / np.linalg.norm(matrix[:3, :3], axis=0), matrix[:3, 3])
