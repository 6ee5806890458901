"""Docking: the fork, the sides of an object it can approach, and where an estimate of the object would send it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.pose import Transform, Transforms, invert, make_transform, rotation_z, transform_points
from warehouse_sim.schema import Pocket

TINE_WIDTH, TINE_THICKNESS, TINE_LENGTH = 0.100, 0.040, 1.150
"""Of one tine (m): the common section of ISO 2330, class 2A; its length is from heel to tip."""
HEEL_GAP = 0.05
"""How far before the estimated face the heel stops (m)."""
MIN_INSERTION = 2.0 / 3.0
"""Fraction of the depth of the object that the tips must be inside before it can be lifted."""
REACH = TINE_LENGTH - HEEL_GAP
"""How far behind the estimated face the tips stop (m)."""
FORK = {
    "tine_width": TINE_WIDTH,
    "tine_thickness": TINE_THICKNESS,
    "tine_length": TINE_LENGTH,
    "heel_gap": HEEL_GAP,
    "min_insertion": MIN_INSERTION,
}
"""As results state it."""


@dataclass(frozen=True, eq=False)
class DockingFace:
    """A side of an object that can be approached, with the pockets that are entered together."""

    name: str
    T_object_dock: Transform
    """Origin at the middle of the openings (or of the side), x inwards, y to the left, z up."""
    depth: float
    """From the face to the far side of the object along x (m)."""
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

    @property
    def upside_down(self) -> Bool[np.ndarray, " n"]:
        """Whether the estimated up points down."""
        return np.abs(self.roll) >= np.pi / 2

    @property
    def wrong_face(self) -> Bool[np.ndarray, " n"]:
        """Whether another side of the object is nearer to the one that is taken for the face; not ``reversed``."""
        return (np.abs(self.yaw) >= np.pi / 4) & ~self.reversed

    @property
    def reversed(self) -> Bool[np.ndarray, " n"]:
        """Whether the estimated insertion axis points out of the object."""
        return np.abs(self.yaw) >= np.pi / 2


def docking_faces(size: Float[np.ndarray, " 3"], pockets: Sequence[Pocket]) -> tuple[DockingFace, ...]:
    """Return the sides from which an object can be taken: those with pockets, or all four upright sides.

    Args:
        size: Outer edge lengths of the object (m), its origin at the centre.
        pockets: All pockets of the object.
    """
    faces: dict[str, tuple[Transform, tuple[Pocket, ...]]] = {}
    if not pockets:
        sides = {"-x": (0.0, 0, -1.0), "+x": (np.pi, 0, 1.0), "-y": (np.pi / 2, 1, -1.0), "+y": (-np.pi / 2, 1, 1.0)}
        for name, (yaw, axis, sign) in sides.items():
            faces[name] = make_transform(rotation_z(yaw), np.eye(3)[axis] * sign * size[axis] / 2.0), ()
    for name in sorted({pocket.face for pocket in pockets}):
        together = tuple(pocket for pocket in pockets if pocket.face == name)
        middle = np.mean([pocket.T_object_pocket[:3, 3] for pocket in together], axis=0)
        faces[name] = make_transform(together[0].T_object_pocket[:3, :3], middle), together
    return tuple(
        DockingFace(name, T_object_dock, _extent_behind(T_object_dock, size), entered)
        for name, (T_object_dock, entered) in faces.items()
    )


def approached_face(
    T_camera_object: Transforms, faces: Sequence[DockingFace], free: Bool[np.ndarray, "n f"] | None = None
) -> Int[np.ndarray, " n"]:
    """Return for each true pose the index of the face whose outward normal points most towards the camera.

    Args:
        T_camera_object: True poses, "n 4 4".
        faces: Sides of the object that can be approached.
        free: Which of them a truck reaches: one of these that the camera is before goes first, if there is any.
    """
    inwards = np.stack([face.T_object_dock[:3, 0] for face in faces])
    camera_in_object = invert(T_camera_object)[:, :3, 3]
    towards = camera_in_object @ -inwards.T
    if free is None:
        return np.argmax(towards, axis=1)
    planes = np.array([-face.T_object_dock[:3, 0] @ face.T_object_dock[:3, 3] for face in faces])
    chosen = free & (towards > planes)
    return np.argmax(np.where(chosen | ~chosen.any(axis=1, keepdims=True), towards, -np.inf), axis=1)


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


def _extent_behind(T_object_dock: Transform, size: Float[np.ndarray, " 3"]) -> float:
    return float(transform_points(invert(T_object_dock), box_corners(size))[:, 0].max())
