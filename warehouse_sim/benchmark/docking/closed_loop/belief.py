"""What the truck believes of the pallet: estimates filtered in the odometry frame, and the entry that it drives to."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float

from warehouse_sim.benchmark.docking.closed_loop.settings import DRIVE, Drift
from warehouse_sim.estimators.tracking.belief import Belief, difference
from warehouse_sim.estimators.tracking.tracker import Tracker, View
from warehouse_sim.evaluation.docking.fork import DockingFace, approached_face
from warehouse_sim.geometry.pose import Transform, invert
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.schema import PoseEstimate


@dataclass(eq=False)
class Believed:
    """The pallet as the truck has it.

    Args:
        symmetry: Of the pallet.
        faces: Its sides.
        drift: What is known of the odometry's errors.
        keeps_first: Whether all estimates after the first are left alone.
    """

    symmetry: SymmetryGroup
    faces: Sequence[DockingFace]
    drift: Drift
    keeps_first: bool = False
    T_odom_object: Transform | None = None
    corrections: int = 0
    """How often the entry moved by more than ``Driving.moved``."""
    _tracker: Tracker | None = field(default=None, init=False)
    _last: Float[np.ndarray, " 3"] | None = field(default=None, init=False)

    def take(self, view: View, estimate: PoseEstimate) -> None:
        """Take over an estimate with a covariance.

        Args:
            view: Its image; ``T_world_camera`` is where the camera was in the odometry frame.
            estimate: In that camera's frame.
        """
        if self.T_odom_object is not None and self.keeps_first:
            return
        if self._tracker is None:
            self._tracker = Tracker({estimate.obj_id: self.symmetry})
        self._drifts(view.T_world_camera[:3, 3])
        self._tracker.step(view, [estimate])
        # All estimates are of the one pallet that the truck was sent to: tracks anywhere are rivals.
        best = max(self._tracker.tracks, key=lambda track: track.support)
        before = None if self.T_odom_object is None else self.entry(view.T_world_camera)
        self.T_odom_object = best.belief.T_world_object
        if before is not None:
            step = difference(self.entry(view.T_world_camera), before)
            aside, turned = abs(float(before[:3, 1] @ step[:3])), abs(float(step[5]))
            self.corrections += aside > DRIVE.moved[0] or turned > DRIVE.moved[1]

    def _drifts(self, place: Float[np.ndarray, " 3"]) -> None:
        """Make tracks less certain by the way (m) since the image before; ``place`` is the camera's (m)."""
        assert self._tracker is not None
        way = 0.0 if self._last is None else float(np.linalg.norm(place - self._last))
        self._last = place
        for track in self._tracker.tracks if way > 0.0 else ():
            track.belief = spread(track.belief, self.drift, place, way)

    def entry(self, T_odom_camera: Transform) -> Transform:
        """Return the dock frame (odometry frame) of the side that is most before a camera."""
        assert self.T_odom_object is not None
        T_camera_object = invert(T_odom_camera) @ self.T_odom_object
        face = self.faces[int(approached_face(T_camera_object[None], self.faces)[0])]
        return self.T_odom_object @ face.T_object_dock


def spread(belief: Belief, drift: Drift, place: Float[np.ndarray, " 3"], way: float) -> Belief:
    """Return a belief in the odometry frame after a way (m) of a truck that knows how good its odometry is.

    An error of heading turns what was seen about the truck's place (m); one of distance moves it. Both are taken for
    independent of those of the way before.
    """
    turn = float(np.deg2rad(np.hypot(drift.turn_deg * way, drift.noise_deg * np.sqrt(way))))
    x, y = (belief.T_world_object[:3, 3] - place)[:2]
    moves = [turn * np.array([-y, x, 0.0, 0.0, 0.0, 1.0])]
    moves += [drift.scale * way * np.eye(6)[axis] for axis in (0, 1)]
    columns = np.stack(moves, axis=1)
    if not columns.any():
        return belief
    information = np.linalg.inv(np.linalg.inv(belief.information) + columns @ columns.T)
    return replace(belief, information=information, common=information @ belief.shared)


@dataclass(frozen=True)
class Aim:
    """Where the believed entry is from the truck."""

    along: float
    """Along the entry's axis from the truck's origin to the entry (m)."""
    aside: float
    """Of the truck's origin to the left of that axis (m)."""
    turned: float
    """Heading of the truck against it (rad), positive to the left."""

    @classmethod
    def of(cls, T_odom_dock: Transform, T_odom_vehicle: Transform) -> "Aim":
        """Return it by both poses in the odometry frame."""
        yaw = np.arctan2(T_odom_dock[1, 0], T_odom_dock[0, 0])
        ahead, left = np.array([np.cos(yaw), np.sin(yaw)]), np.array([-np.sin(yaw), np.cos(yaw)])
        away = T_odom_vehicle[:2, 3] - T_odom_dock[:2, 3]
        turned = np.arctan2(T_odom_vehicle[1, 0], T_odom_vehicle[0, 0]) - yaw
        turned = (turned + np.pi) % (2.0 * np.pi) - np.pi
        return cls(-float(ahead @ away), float(left @ away), float(turned))
