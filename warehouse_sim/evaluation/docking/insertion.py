"""Insertion: where a fork that trusts an estimate stops, and the clearance that the true object leaves it on the way.

A pair of thresholds such as "50 mm and 3 degrees" cannot both be spent: at 3 degrees an EPAL 1 pallet leaves 6 mm of
the 64 mm beside a tine. So the tines are swept through the pockets, and the clearance that is left is measured.

Where an estimate does not dock, one error is to blame: the one that alone uses up most of the clearance.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from jaxtyping import Float

from warehouse_sim.evaluation.docking.fork import (
    HEEL_GAP,
    MIN_INSERTION,
    REACH,
    TINE_THICKNESS,
    TINE_WIDTH,
    DockingErrors,
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


FailureAxis = Literal[
    "lateral",
    "vertical",
    "yaw",
    "pitch",
    "roll",
    "too_deep",
    "too_short",
    "board",
    "wrong_face",
    "upside_down",
    "reversed",
]
FAILURE_AXES: tuple[FailureAxis, ...] = get_args(FailureAxis)
_MEASURED = 7
"""The first of them are measured against the clearance that there is; the others otherwise."""
_LEAST_CLEARANCE = 1e-3
"""Metres. Where the fork does not fit at all, every estimate fails, and the fractions still compare."""


def failure_axes(
    errors: DockingErrors,
    slack: DockingSlack,
    face: DockingFace,
    clearance: Float[np.ndarray, " n"] | None = None,
) -> list[FailureAxis]:
    """Name for each estimate the error that alone uses up most of the clearance it has.

    Where something fails, only what fails is named: a fork that clears the walls and stops too deep is "too_deep". One
    that clears the nominal pockets and meets a board of the pallet's own mesh is "board".

    Args:
        errors: Of the estimates.
        slack: What they leave in the nominal pockets.
        face: The approached face.
        clearance: What they leave to the surface of the pallet's own mesh (m).
    """
    at_walls, along = _used_at_walls(errors, face), _used_along(slack, face)
    hits = np.minimum(slack.lateral, slack.vertical) < 0.0
    fails = np.stack([*[hits] * len(at_walls), slack.heel < 0.0, slack.tips < 0.0])
    used = np.where(fails | ~fails.any(axis=0), np.concatenate([at_walls, along]), -np.inf)
    names = np.array(FAILURE_AXES[:_MEASURED], dtype="<U16")[used.argmax(axis=0)]
    if clearance is not None:
        names = np.where(~fails.any(axis=0) & (clearance < 0.0), "board", names)
    names = np.where(errors.wrong_face, "wrong_face", names)
    names = np.where(errors.reversed, "reversed", names)
    return np.where(errors.upside_down, "upside_down", names).tolist()


def _used_at_walls(errors: DockingErrors, face: DockingFace) -> Float[np.ndarray, "5 n"]:
    """Offsets count as they are, an angle by the chord that it moves the tip (yaw, pitch) or the outer tine (roll).

    Each is divided by the clearance beside or above a tine in the narrowest pocket.
    """
    clear = np.min([pocket.size for pocket in face.pockets], axis=0)
    beside, above = np.maximum((clear[1:] - [TINE_WIDTH, TINE_THICKNESS]) / 2.0, _LEAST_CLEARANCE)
    length = max(insertion_depth(pocket) for pocket in face.pockets)
    openings = np.stack([pocket.T_object_pocket[:3, 3] for pocket in face.pockets])
    aside = np.abs(transform_points(invert(face.T_object_dock), openings)[:, 1]).max() + TINE_WIDTH / 2.0
    return np.stack(
        [
            np.abs(errors.lateral) / beside,
            np.abs(errors.vertical) / above,
            2.0 * length * np.abs(np.sin(errors.yaw / 2.0)) / beside,
            2.0 * length * np.abs(np.sin(errors.pitch / 2.0)) / above,
            2.0 * aside * np.abs(np.sin(errors.roll / 2.0)) / above,
        ]
    )


def _used_along(slack: DockingSlack, face: DockingFace) -> Float[np.ndarray, "2 n"]:
    """Of the clearance before the face (too deep) and beyond the least insertion (too short)."""
    before, beyond = HEEL_GAP, REACH - MIN_INSERTION * face.depth
    return np.stack(
        [(before - slack.heel) / max(before, _LEAST_CLEARANCE), (beyond - slack.tips) / max(beyond, _LEAST_CLEARANCE)]
    )
