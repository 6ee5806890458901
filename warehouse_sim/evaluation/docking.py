"""Docking: whether a fork that trusts the estimate enters the true pockets.

A pair of thresholds such as "50 mm and 3 degrees" cannot both be spent: at 3 degrees an EPAL 1 pallet leaves 4 mm of
the 64 mm beside a tine. So the tines are swept through the pockets, and the room that is left is measured.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from jaxtyping import Float, Int

from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.pose import Transform, Transforms, invert, make_transform, rotation_z, transform_points
from warehouse_sim.schema import Pocket

FailureAxis = Literal["lateral", "vertical", "yaw", "pitch", "roll"]
FAILURE_AXES: tuple[FailureAxis, ...] = get_args(FailureAxis)


@dataclass(frozen=True)
class ForkConfig:
    """A pair of tines; the default is the common 100 x 40 mm section, 1150 mm long."""

    tine_width: float = 0.100
    """Width of one tine (m), > 0."""
    tine_thickness: float = 0.040
    """Thickness of one tine (m), > 0."""
    tine_length: float = 1.150
    """How far a tine can enter (m), > 0; a shorter pocket limits it."""


@dataclass(frozen=True, eq=False)
class DockingFace:
    """A side of an object that can be approached, with the pockets that are entered together."""

    name: str
    T_object_dock: Transform
    """Origin at the middle of the openings (or of the side), x inwards, y to the left, z up."""
    pockets: tuple[Pocket, ...] = ()


@dataclass(frozen=True, eq=False)
class DockingErrors:
    """Where an estimate would send the fork, in the true docking frame; the pivot is the entry, not the centre."""

    depth: Float[np.ndarray, " n"]
    """Along the insertion axis (m), positive too deep."""
    lateral: Float[np.ndarray, " n"]
    """Positive to the left of an approaching driver (m)."""
    vertical: Float[np.ndarray, " n"]
    """Positive too high (m)."""
    yaw: Float[np.ndarray, " n"]
    """About the vertical axis (rad), positive turns left."""
    pitch: Float[np.ndarray, " n"]
    """Tip of the fork up or down (rad), positive up."""
    roll: Float[np.ndarray, " n"]
    """About the insertion axis (rad)."""


def docking_faces(size: Float[np.ndarray, " 3"], pockets: Sequence[Pocket]) -> tuple[DockingFace, ...]:
    """Return the sides from which an object can be taken: those with pockets, or all four upright sides.

    Args:
        size: Outer edge lengths of the object (m), its origin at the centre.
        pockets: All pockets of the object.
    """
    if not pockets:
        sides = {"-x": (0.0, 0, -1.0), "+x": (np.pi, 0, 1.0), "-y": (np.pi / 2, 1, -1.0), "+y": (-np.pi / 2, 1, 1.0)}
        return tuple(
            DockingFace(name, make_transform(rotation_z(yaw), np.eye(3)[axis] * sign * size[axis] / 2.0))
            for name, (yaw, axis, sign) in sides.items()
        )
    faces = []
    for name in sorted({pocket.face for pocket in pockets}):
        together = tuple(pocket for pocket in pockets if pocket.face == name)
        middle = np.mean([pocket.T_object_pocket[:3, 3] for pocket in together], axis=0)
        faces.append(DockingFace(name, make_transform(together[0].T_object_pocket[:3, :3], middle), together))
    return tuple(faces)


def approached_face(T_camera_object: Transforms, faces: Sequence[DockingFace]) -> Int[np.ndarray, " n"]:
    """Return for each true pose the index of the face whose outward normal points most towards the camera."""
    inwards = np.stack([face.T_object_dock[:3, 0] for face in faces])
    camera_in_object = invert(T_camera_object)[:, :3, 3]
    return np.argmax(camera_in_object @ -inwards.T, axis=1)


def docking_errors(T_object_estimated: Transforms, face: DockingFace) -> DockingErrors:
    """Express estimates, "n 4 4" in the true object frame, as errors at the entry of ``face``."""
    T = invert(face.T_object_dock) @ T_object_estimated @ face.T_object_dock
    return DockingErrors(
        depth=T[:, 0, 3],
        lateral=T[:, 1, 3],
        vertical=T[:, 2, 3],
        yaw=np.arctan2(T[:, 1, 0], T[:, 0, 0]),
        pitch=np.arcsin(np.clip(T[:, 2, 0], -1.0, 1.0)),
        roll=np.arctan2(T[:, 2, 1], T[:, 2, 2]),
    )


def docking_slack(
    T_object_estimated: Transforms, face: DockingFace, fork: ForkConfig
) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, " n"]]:
    """Return the room (m) that fully inserted tines leave to the true pocket walls, sideways and vertically.

    Each tine is centred in its pocket in the *estimated* frame and swept along the insertion axis. The swept volume is
    a prism, so its end corners decide: docking succeeds with margin m when every corner keeps at least m in y and z.

    Args:
        T_object_estimated: "n 4 4" in the true object frame, under the best symmetry.
        face: The approached face with its pockets.
        fork: The tines.

    Returns:
        Lateral and vertical slack; negative where a tine cuts into a wall.
    """
    slack = np.full((len(T_object_estimated), 2), np.inf)
    for pocket in face.pockets:
        length = insertion_depth(pocket, fork)
        tine = box_corners(np.array([length, fork.tine_width, fork.tine_thickness]))
        tine[:, 0] += length / 2.0
        T_pocket_tine = invert(pocket.T_object_pocket) @ T_object_estimated @ pocket.T_object_pocket
        corners = transform_points(T_pocket_tine, tine)
        slack = np.minimum(slack, (pocket.size[1:] / 2.0 - np.abs(corners[..., 1:])).min(axis=1))
    return slack[:, 0], slack[:, 1]


def insertion_depth(pocket: Pocket, fork: ForkConfig) -> float:
    """Return how far (m) a tine enters: the pocket's depth or the tine's length, whichever is smaller."""
    return float(min(pocket.size[0], fork.tine_length))


def failure_axes(errors: DockingErrors, face: DockingFace, fork: ForkConfig) -> list[FailureAxis]:
    """Name for each estimate the error that alone uses up most of the room it has.

    Offsets count as they are; an angle counts by the chord that it moves the tip of the fork (yaw, pitch) or the
    outermost tine (roll). Each is divided by the room beside or above a tine in the narrowest pocket.
    """
    clear = np.min([pocket.size for pocket in face.pockets], axis=0)
    # A millimetre at least: where the fork does not fit at all, every estimate fails, and the shares still compare.
    beside, above = np.maximum((clear[1:] - [fork.tine_width, fork.tine_thickness]) / 2.0, 1e-3)
    length = max(insertion_depth(pocket, fork) for pocket in face.pockets)
    in_dock = transform_points(
        invert(face.T_object_dock), np.stack([pocket.T_object_pocket[:3, 3] for pocket in face.pockets])
    )
    reach = np.abs(in_dock[:, 1]).max() + fork.tine_width / 2.0
    used = np.stack(
        [
            np.abs(errors.lateral) / beside,
            np.abs(errors.vertical) / above,
            2.0 * length * np.abs(np.sin(errors.yaw / 2.0)) / beside,
            2.0 * length * np.abs(np.sin(errors.pitch / 2.0)) / above,
            2.0 * reach * np.abs(np.sin(errors.roll / 2.0)) / above,
        ]
    )
    return [FAILURE_AXES[index] for index in used.argmax(axis=0)]
