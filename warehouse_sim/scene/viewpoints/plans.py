"""Drawing drives: along the aisle, round a corner towards a target beside it, straight up to a pallet's pockets.

Each is first laid out at full length and then cut to the part with room for the vehicle and targets in view.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.pose import Transform, Transforms
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.viewpoints.config import ViewpointsConfig
from warehouse_sim.scene.viewpoints.drives import Arc, Drive, FloorPose, Mount, Path, SpeedProfile
from warehouse_sim.scene.viewpoints.framing import shows, target_in_view
from warehouse_sim.scene.viewpoints.free_space import FreeSpace
from warehouse_sim.scene.viewpoints.mountings import Mounting, pose_on_floor
from warehouse_sim.scene.viewpoints.single import sample_lift, sample_mount
from warehouse_sim.schema import ObjectInstance, ObjectModel, Viewpoint


def entries_of(target: ObjectInstance, model: ObjectModel) -> list[FloorPose]:
    """Return the middle of each side of ``target`` that forks can enter, heading inwards; all four without pockets."""
    sides: dict[str, list[Transform]] = {}
    for pocket in model.pockets:
        sides.setdefault(pocket.face, []).append(pocket.T_object_pocket)
    if not sides:
        x, y = float(model.size[0]) / 2, float(model.size[1]) / 2
        inwards = ((-x, 0.0, 0.0), (x, 0.0, np.pi), (0.0, -y, np.pi / 2), (0.0, y, -np.pi / 2))
        sides = {str(number): [pose_on_floor(*side)] for number, side in enumerate(inwards)}
    return [_middle(target.T_world_object @ np.array(T_object_side)) for T_object_side in sides.values()]


def _middle(T_world_side: Transforms) -> FloorPose:
    x, y, _ = T_world_side[:, :3, 3].mean(axis=0)
    ahead = T_world_side[0, :3, 0]
    return FloorPose(float(x), float(y), float(np.arctan2(ahead[1], ahead[0])))


def pose_before(entry: FloorPose, distance: float, aside: float, turn: float) -> FloorPose:
    """Return a pose on a line into an entry.

    Args:
        entry: Middle of the entry, heading inwards.
        distance: From the pose to the entry along the line (m).
        aside: Where the line meets the entry, left of its middle (m).
        turn: Of the line against the entry's own direction (rad).
    """
    meeting = FloorPose(entry.x, entry.y, entry.yaw + np.pi / 2).after(aside, 0.0)
    return FloorPose(meeting.x, meeting.y, entry.yaw + turn).after(-distance, 0.0)


SPEEDS = {
    "drive": Distribution.uniform(1.5, 2.5),
    "turn_in": Distribution.uniform(0.5, 1.0),
    "approach": Distribution.uniform(0.3, 0.8),
}
"""Of the vehicle (m/s) where the recipe does not say; practical priors, walking speed and below."""
_ACCELERATION = 0.5
"""Of speeding up and braking (m/s^2)."""
_LEAST_RUN = 1.0
"""An approach shorter than this (m) is none."""
_LANE_EDGE = 1.2
"""Drives along the aisle keep this distance (m) from its edges, or a third of its width where it is narrow."""
_LEAST_RUN_UP = 0.3
"""Least straight before the corner of a turn-in (m)."""
_RUN_OUT = Distribution.uniform(0.3, 1.5)
"""Straight between the corner and the end of a turn-in (m)."""
_STEP = 0.2
"""Distance between the places at which a path is tested (m)."""


@dataclass(frozen=True, eq=False)
class Planner:
    """Draws drives of one kind of camera through one scene; None stands for a drive that cannot be made."""

    space: FreeSpace
    config: ViewpointsConfig
    mounting: Mounting
    rng: np.random.Generator

    def sample(self, target: ObjectInstance | None) -> Drive | None:
        """Draw a drive of the recipe's trajectory for ``target``; without one, a drive along the aisle."""
        if target is None:
            return self._along()
        return self._turn_in(target) if self.config.trajectory == "turn_in" else self._approach(target)

    def is_shown(self, view: Viewpoint, aim: ObjectInstance | None) -> ObjectInstance | None:
        """Return the target that ``view`` shows: on an approach the aimed-at one and no other."""
        if self.config.trajectory == "approach":
            return aim if aim is not None and shows(view, aim, self.space, self.config) else None
        return target_in_view(view, self.space, self.config, aim)

    def _along(self) -> Drive | None:
        """Draw a straight along the aisle, either way, as long as sampled or, within the wanted range, as can be."""
        area, mount = self.space.area, self._sample_mount(None)
        yaw = float(np.pi * self.rng.integers(2) + np.deg2rad(self.config.drive.heading_deg.sample(self.rng)))
        wanted, whole = self.config.drive.length.sample(self.rng), area.x_max - area.x_min
        edge = min(_LANE_EDGE, (area.y_max - area.y_min) / 3)
        lateral = self.rng.uniform(area.y_min + edge, area.y_max - edge)
        middle = FloorPose((area.x_min + area.x_max) / 2, lateral, yaw)
        lane = Path(middle.after(-whole / 2, 0.0), (Arc(whole),))
        places = _places(lane)
        first, last = _longest_run([self._serves(mount, lane.at(place)[0], None) for place in places])
        length = min(wanted, places[last] - places[first])
        if length < self.config.drive.length.low:
            return None
        begin = places[first] + self.rng.uniform(0.0, places[last] - places[first] - length)
        return self._drive(mount, lane.part(begin, begin + length), None)

    def _turn_in(self, target: ObjectInstance) -> Drive | None:
        """Draw a straight along the aisle and a quarter circle, from either side, that end before ``target``."""
        mount, end = self._sample_mount(target), self._end_before(target, self.config.drive.stop.sample(self.rng))
        if end is None or self.space.in_aisle(target):
            return None
        radius, left = self.config.drive.radius.sample(self.rng), 2 * self.rng.integers(2) - 1
        run_up, run_out = self.config.drive.length.sample(self.rng), _RUN_OUT.sample(self.rng)
        corner = Arc(radius * np.pi / 2, left / radius)
        path = Path.ending_at(end, (Arc(run_up), corner, Arc(run_out)))
        return self._cut(mount, path, target, least=corner.length + run_out + _LEAST_RUN_UP)

    def _approach(self, target: ObjectInstance) -> Drive | None:
        """Draw a straight up to a side of ``target`` that forks can enter."""
        mount, stop = self._sample_mount(target), self.config.drive.stop.sample(self.rng)
        end = self._end_before(target, stop)
        if end is None:
            return None
        path = Path.ending_at(end, (Arc(self.config.drive.start.sample(self.rng) - stop),))
        return self._cut(mount, path, target, least=_LEAST_RUN)

    def _cut(self, mount: Mount, path: Path, aim: ObjectInstance, least: float) -> Drive | None:
        """Return the drive over the last part of ``path`` that can be driven, if it is ``least`` (m) or longer."""
        end = path.at(path.length)[0]
        if not mount.is_clear(end, self.space, self.config.clearance):
            return None
        if not shows(mount.view(end), aim, self.space, self.config):
            return None
        begin = path.length
        for place in _places(path)[-2::-1]:
            if not self._serves(mount, path.at(place)[0], aim):
                break
            begin = place
        return self._drive(mount, path.part(begin, path.length), aim) if path.length - begin >= least else None

    def _serves(self, mount: Mount, pose: FloorPose, aim: ObjectInstance | None) -> bool:
        """Return whether there is room at ``pose`` and what was requested is in view."""
        is_clear = mount.is_clear(pose, self.space, self.config.clearance)
        return is_clear and self.is_shown(mount.view(pose), aim) is not None

    def _drive(self, mount: Mount, path: Path, aim: ObjectInstance | None) -> Drive:
        config = self.config.drive
        speed = (config.speed or SPEEDS[self.config.trajectory]).sample(self.rng)
        rolling = self.config.trajectory == "approach"
        return Drive(mount, path, SpeedProfile.over(path.length, speed, _ACCELERATION, rolling), aim)

    def _sample_mount(self, target: ObjectInstance | None) -> Mount:
        height, pitch, roll = sample_mount(self.mounting, self.config, self.rng)
        lift = sample_lift(self.config, target, self.space, self.rng) if target else 0.0
        return Mount(self.config.kind, self.mounting, height + lift, pitch, lift, roll)

    def _end_before(self, target: ObjectInstance, gap: float) -> FloorPose | None:
        """Draw where the vehicle stands when its tip is ``gap`` (m) before a side of ``target`` at the aisle."""
        entries = entries_of(target, self.space.models[target.model])
        aside = self.config.drive.lateral.sample(self.rng)
        turn = float(np.deg2rad(self.config.drive.heading_deg.sample(self.rng)))
        poses = [pose_before(entry, gap + self.mounting.tip, aside, turn) for entry in entries]
        open_poses = [pose for pose in poses if self.space.area.contains(np.array([pose.x, pose.y]))]
        return open_poses[self.rng.integers(len(open_poses))] if open_poses else None


def _places(path: Path) -> Float[np.ndarray, " n"]:
    """Return distances (m) from the start at which a path is tested, both ends among them."""
    return np.linspace(0.0, path.length, int(np.ceil(path.length / _STEP)) + 1)


def _longest_run(good: Sequence[bool]) -> tuple[int, int]:
    """Return the first and the last index of the longest run of true; the same index twice when there is none."""
    best, begin = (0, 0), None
    for index, is_good in enumerate([*good, False]):
        if is_good and begin is None:
            begin = index
        elif not is_good and begin is not None:
            best = max(best, (begin, index - 1), key=lambda run: run[1] - run[0])
            begin = None
    return best
