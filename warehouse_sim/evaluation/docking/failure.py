"""Which error to blame when an estimate does not dock."""

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
)
from warehouse_sim.evaluation.docking.insertion import DockingSlack, insertion_depth
from warehouse_sim.geometry.pose import invert, transform_points

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
