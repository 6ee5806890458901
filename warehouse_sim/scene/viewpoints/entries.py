"""Where a vehicle drives into a load: the sides with pockets, and poses before them."""

import numpy as np

from warehouse_sim.geometry.pose import Transform, Transforms
from warehouse_sim.scene.viewpoints.paths import FloorPose
from warehouse_sim.scene.viewpoints.vehicles import pose_on_floor
from warehouse_sim.schema import ObjectInstance, ObjectModel


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
