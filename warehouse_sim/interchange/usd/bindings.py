"""OpenUSD's Python modules, imported when a scene is written or read, and what every prim has: a name and a place.

Translation and orientation are in double precision, as simulators move them.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.pose import Transform, make_transform, quat_wxyz_from_matrix
from warehouse_sim.optional import require


@dataclass(frozen=True)
class Bindings:
    """The modules of ``pxr`` that scenes need, without their prefix ``Usd``."""

    Gf: Any
    Sdf: Any
    Tf: Any
    Vt: Any
    Usd: Any
    Geom: Any
    Lux: Any
    Physics: Any
    Semantics: Any
    Shade: Any


@cache
def bindings() -> Bindings:
    """Return OpenUSD's modules.

    Raises:
        MissingPackageError: usd-core is not installed.
    """
    plain = {name: f"pxr.{name}" for name in ("Gf", "Sdf", "Tf", "Vt", "Usd")}
    domains = {name: f"pxr.Usd{name}" for name in ("Geom", "Lux", "Physics", "Semantics", "Shade")}
    return Bindings(**{name: require(path, "interchange", "for USD") for name, path in (plain | domains).items()})


def prim_names(names: Iterable[str]) -> dict[str, str]:
    """Return a valid prim name for each of ``names``; no two share one, not even in upper and lower case."""
    found: dict[str, str] = {}
    taken: set[str] = set()
    for name in names:
        valid = candidate = bindings().Tf.MakeValidIdentifier(name)
        number = 1
        while candidate.lower() in taken:
            number += 1
            candidate = f"{valid}_{number}"
        taken.add(candidate.lower())
        found[name] = candidate
    return found


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
