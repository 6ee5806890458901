"""Insertion: where a fork that trusts an estimate stops, and the clearance that the true object leaves it on the way.

A pair of thresholds such as "50 mm and 3 degrees" cannot both be spent: at 3 degrees an EPAL 1 pallet leaves 6 mm of
the 64 mm beside a tine. So the tines are swept through the pockets, and the clearance that is left is measured.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from warehouse_sim.evaluation.docking.fork import (
    HEEL_GAP,
    MIN_INSERTION,
    REACH,
    TINE_THICKNESS,
    TINE_WIDTH,
    DockingFace,
    docking_errors,
)
from warehouse_sim.geometry.pose import Transform, Transforms, invert, transform_points
from warehouse_sim.schema import Pocket

# Around the section of a tine, so that neighbours share an edge of its tip.
_AROUND = np.array([[-0.5, -0.5], [-0.5, 0.5], [0.5, 0.5], [0.5, -0.5]])


@dataclass(frozen=True, eq=False)
class DockingSlack:
    """Clearance an estimate leaves (m), negative where it fails; -inf if upside down, reversed, at a wrong face."""

    lateral: Float[np.ndarray, " n"]
    """Beside the tines, to the walls of the true pockets; inf where the tines stay outside."""
    vertical: Float[np.ndarray, " n"]
    """Above and below the tines."""
    heel: Float[np.ndarray, " n"]
    """Between the heel of the tines and the true face; negative where the truck pushes the object."""
    tips: Float[np.ndarray, " n"]
    """By which the tips are farther inside than they must be."""

    @property
    def depth(self) -> Float[np.ndarray, " n"]:
        """The smaller clearance along the insertion axis."""
        return np.minimum(self.heel, self.tips)


def docking_slack(
    T_object_estimated: Transforms,
    face: DockingFace,
    T_dock_tines: Sequence[Transform] | None = None,
) -> DockingSlack:
    """Drive the fork straight along the estimated insertion axis to where the estimate says, and measure the clearance.

    Each tine is centred in its pocket in the *estimated* frame, and stops with its heel ``HEEL_GAP`` before the
    estimated face. What it sweeps is its own prism, prolonged backwards.

    Args:
        T_object_estimated: "n 4 4" in the true object frame, under the best symmetry.
        face: The approached face with its pockets.
        T_dock_tines: Where the tines aim at instead, in the estimated dock frame, one for each pocket of the face.
    """
    aims = [invert(face.T_object_dock) @ pocket.T_object_pocket for pocket in face.pockets]
    walls = np.full((len(T_object_estimated), 2), np.inf)
    heel, tips = np.full((2, len(T_object_estimated)), np.inf)
    for pocket, aim in zip(face.pockets, T_dock_tines or aims, strict=True):
        T_estimate = T_object_estimated @ face.T_object_dock @ aim
        T_dock_tine = invert(face.T_object_dock) @ T_estimate
        heel = np.minimum(heel, -transform_points(T_dock_tine, _section(-HEEL_GAP))[..., 0].max(axis=1))
        inside = transform_points(T_dock_tine, _section(REACH))[..., 0].min(axis=1)
        tips = np.minimum(tips, inside - MIN_INSERTION * face.depth)
        walls = np.minimum(walls, _clearance_to_walls(invert(pocket.T_object_pocket) @ T_estimate, pocket))
    errors = docking_errors(T_object_estimated, face)
    astray = errors.upside_down | errors.reversed | errors.wrong_face
    return DockingSlack(*(np.where(astray, -np.inf, clearance) for clearance in (*walls.T, heel, tips)))


def insertion_depth(pocket: Pocket) -> float:
    """Return how deep in the pocket (m) a tine gets when the estimate is right."""
    return float(min(pocket.size[0], REACH))


def _section(x: float) -> Float[np.ndarray, "4 3"]:
    around = _AROUND * [TINE_WIDTH, TINE_THICKNESS]
    return np.column_stack([np.full(4, x), around])


def _clearance_to_walls(T_pocket_tine: Transforms, pocket: Pocket) -> Float[np.ndarray, "n 2"]:
    """Return the least clearance in y and z over the part of the swept prism that is in the pocket.

    That part is convex, so its corners decide: they lie where an edge of the prism begins, ends, or crosses the entry
    or the end of the pocket. Four edges run backwards from the tip without end, four go around the tip.
    """
    tip = transform_points(T_pocket_tine, _section(REACH))
    backwards = np.broadcast_to(-T_pocket_tine[:, None, :3, 0], tip.shape)
    start = np.concatenate([tip, tip], axis=1)
    along = np.concatenate([backwards, np.roll(tip, -1, axis=1) - tip], axis=1)
    length = np.repeat([np.inf, 1.0], 4)
    # An edge across the pocket crosses neither plane: a slope too small to matter puts the crossings far away.
    slope = np.where(np.abs(along[..., 0]) < 1e-12, 1e-12, along[..., 0])
    crossings = np.sort((np.array([0.0, pocket.size[0]]) - start[..., :1]) / slope[..., None], axis=-1)
    first, last = np.maximum(crossings[..., 0], 0.0), np.minimum(crossings[..., 1], length)
    ends = start[..., None, :] + np.stack([first, last], axis=-1)[..., None] * along[..., None, :]
    clearance = np.where((first <= last)[..., None, None], pocket.size[1:] / 2.0 - np.abs(ends[..., 1:]), np.inf)
    return clearance.min(axis=(1, 2))
