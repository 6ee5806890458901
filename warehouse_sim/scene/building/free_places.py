"""Places that are still free, along the walls and on the floor."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.scene.draft import Area, SceneDraft
from warehouse_sim.schema import ObjectModel

_AIR = 0.004
"""Between a thing and the wall that it hangs on (m): ribs and frames stand out no farther than the wall's face."""
_BESIDE_LOADS = 0.05
"""Least distance to the places of loads (m)."""
_BEFORE_DOOR = np.array([0.0, 0.3, 0.0])
"""What stays free before doors beyond their own box (m)."""


@dataclass(frozen=True)
class Wall:
    """The inner face of a wall."""

    turn: float
    """Rotation about z of what hangs on it with its back at +y (rad)."""
    at: float
    """y of the face for the front and back walls, x for the walls at the ends (m)."""
    low: float
    high: float
    """Ends of the wall along x, or along y (m)."""

    def pose(self, along: float, z: float, depth: float) -> Transform:
        """Return the pose of something ``depth`` m deep whose middle is ``along`` the wall at the height ``z`` (m)."""
        inward = np.array([np.sin(self.turn), -np.cos(self.turn)])
        off = inward * (depth / 2 + _AIR)
        sideways = abs(np.sin(self.turn)) > 0.5
        x, y = (self.at, along) if sideways else (along, self.at)
        return make_transform(rotation_z(self.turn), np.array([x + off[0], y + off[1], z]))


def walls_of(floor: Area) -> tuple[Wall, ...]:
    """Return the four walls around ``floor``: front, back, and those at the ends of least and of greatest x."""
    return (
        Wall(0.0, floor.y_max, floor.x_min, floor.x_max),
        Wall(np.pi, floor.y_min, floor.x_min, floor.x_max),
        Wall(np.pi / 2, floor.x_min, floor.y_min, floor.y_max),
        Wall(-np.pi / 2, floor.x_max, floor.y_min, floor.y_max),
    )


class FreePlaces:
    """Tells where nothing stands yet, and adds things there.

    Args:
        draft: What stands so far; paint on the floor is in nobody's way.
        kept: Places of loads that are still to come.
    """

    def __init__(self, draft: SceneDraft, kept: Sequence[OrientedBox] = ()) -> None:
        self._draft, self._kept = draft, BoxStack.of(list(kept))

    def add(self, model: ObjectModel, pose: Transform, clearance: float = 0.1) -> bool:
        """Add ``model`` unless something comes nearer than ``clearance`` (m); return whether it was added."""
        if not self.is_free(model, pose, clearance):
            return False
        self._draft.add(model, pose)
        return True

    def is_free(self, model: ObjectModel, pose: Transform, clearance: float) -> bool:
        """Return whether nothing but the shell comes within ``clearance`` (m) of the model's box."""
        if not self._kept.clear_of(OrientedBox(pose, model.size), _BESIDE_LOADS):
            return False
        half = np.abs(pose[:3, :3]) @ model.size / 2
        solids = self._draft.solids()
        near = solids.near(pose[:3, 3] - half, pose[:3, 3] + half, clearance)
        _, high = solids.extents
        near &= high[:, 2] > 0.03
        owners = set(solids.owner[near].tolist())
        return all(self._is_shell(number) for number in owners) and not self._blocks_door(pose[:3, 3], half + clearance)

    def along(self, wall: Wall, model: ObjectModel, z: float, rng: np.random.Generator, count: int) -> Iterator[float]:
        """Hang or stand ``count`` of ``model`` at free places of ``wall``, ``z`` their middle; yield those places."""
        margin = model.size[0] / 2 + 0.4
        if wall.high - wall.low <= 2 * margin:
            return
        left = count
        for along in rng.uniform(wall.low + margin, wall.high - margin, 12 * count):
            if left and self.add(model, wall.pose(float(along), z, float(model.size[1])), 0.25):
                left -= 1
                yield float(along)

    def _blocks_door(self, middle: Float[np.ndarray, " 3"], half: Float[np.ndarray, " 3"]) -> bool:
        """Return whether the box stands in or before a door, open or shut."""
        for item in self._draft.instances:
            model = self._draft.models[item.model]
            if model.class_name == "door":
                reach = np.abs(item.T_world_object[:3, :3]) @ model.size / 2
                if (np.abs(middle - item.T_world_object[:3, 3]) < half + reach + _BEFORE_DOOR).all():
                    return True
        return False

    def _is_shell(self, number: int) -> bool:
        name = self._draft.models[self._draft.instances[number - 1].model].class_name
        return name in ("wall", "floor", "ceiling")
