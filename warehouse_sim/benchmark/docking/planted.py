"""Known errors on top of the ground truth, spread around the limits of the swept-volume check."""

import numpy as np

from warehouse_sim.evaluation.docking.fork import DockingFace, ForkConfig
from warehouse_sim.geometry.pose import Transform, invert, make_transform, rotation_y, rotation_z

AXES = ("lateral", "vertical", "depth", "yaw", "pitch")
KINDS = ("oracle", "too deep", *AXES, "all")
"""The ground truth itself, 0.2 m too deep, one error alone, and all five at once."""
_DEEP = 0.2
_ALONE, _TOGETHER = 2.0, 0.7
"""Errors are uniform up to this fraction of their limit, when alone and when all five come together."""


def planted(kind: str, face: DockingFace, fork: ForkConfig, rng: np.random.Generator) -> Transform:
    """Return an estimate in the true object frame with an error of this kind, drawn from ``rng``."""
    errors = dict.fromkeys(AXES, 0.0)
    if kind == "too deep":
        errors["depth"] = _DEEP
    for name in AXES if kind == "all" else (kind,) if kind in AXES else ():
        below, above = limits(face, fork)[name]
        fraction = float(rng.uniform(-1.0, 1.0)) * (_TOGETHER if kind == "all" else _ALONE)
        errors[name] = fraction * (above if fraction > 0.0 else below)
    return misplaced(face, **errors)


def limits(face: DockingFace, fork: ForkConfig) -> dict[str, tuple[float, float]]:
    """Return how far each error alone may go, below and above 0 (m, rad), both positive, in the middle of a pocket."""
    clear = np.min([pocket.size for pocket in face.pockets], axis=0)
    beside, above = (clear[1:] - [fork.tine_width, fork.tine_thickness]) / 2.0
    inside = min(float(clear[0]), fork.reach)
    short = max(fork.reach - fork.min_insertion * face.depth, 0.0)
    return {
        "lateral": (beside, beside),
        "vertical": (above, above),
        "depth": (short, fork.heel_gap),
        "yaw": (beside / inside, beside / inside),
        "pitch": (above / inside, above / inside),
    }


def misplaced(face: DockingFace, depth: float, lateral: float, vertical: float, yaw: float, pitch: float) -> Transform:
    """Return an estimate in the true object frame that is wrong by that much at the entry of ``face`` (m, rad)."""
    off = make_transform(rotation_z(yaw) @ rotation_y(-pitch), np.array([depth, lateral, vertical]))
    return face.T_object_dock @ off @ invert(face.T_object_dock)
