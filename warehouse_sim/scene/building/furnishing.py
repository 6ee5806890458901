"""What hangs on walls and stands or is painted beside ways: signs, fire equipment, guards, markings, labels, bins.

Each finds a free place along the walls or on the floor.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.building.floor_marks import PAINT
from warehouse_sim.catalog.building.safety import AISLE_SIGNS, FLOOR_LABELS
from warehouse_sim.catalog.building.to_size import hanging_rods
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.scene.building.services import Roof, ServicesConfig
from warehouse_sim.scene.draft import Area, SceneDraft
from warehouse_sim.scene.solids import Solids
from warehouse_sim.schema import ObjectInstance, ObjectModel

_OFF_WALL = 0.004
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
        off = inward * (depth / 2 + _OFF_WALL)
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
        self._solids, self._counted = draft.solids(), len(draft.instances)

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
        solids = self._solids_so_far()
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

    def _solids_so_far(self) -> Solids:
        """Return the boxes of all that stands in the draft; those of what came since the last time are added."""
        new = self._draft.instances[self._counted :]
        if new:
            self._solids = self._solids.joined(Solids.of(new, self._draft.models))
            self._counted += len(new)
        return self._solids

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


_EYE = 1.7
_LIFT = 0.0004
"""By which a mark lies above those that were painted before it (m)."""


def furnish(
    draft: SceneDraft,
    config: ServicesConfig,
    roof: Roof,
    aisle: Area,
    rng: np.random.Generator,
    kept: Sequence[OrientedBox] = (),
) -> None:
    """Add what ``config`` requires where there is room beside the places of loads, ``kept``."""
    free, walls = FreePlaces(draft, kept), walls_of(roof.floor)
    if config.guards:
        _guard_columns(draft)
        _guard_docks(draft)
        _guard_gates(draft, free)
        _add_rails(free, walls[1], aisle)
    if config.signs:
        _add_signs(draft, free, walls, roof, aisle, rng)
    if config.fire_equipment:
        _add_fire_equipment(free, walls, rng)
    for _ in range(config.bins):
        wall = walls[int(rng.integers(4))]
        model = catalog_object("rubbish_bin")
        list(free.along(wall, model, float(model.size[2]) / 2, rng, 1))
    if config.markings:
        _paint_markings(draft, aisle, roof.floor)
    if config.floor_labels:
        _stick_labels(draft, aisle)
    for _ in range(config.floor_signs):
        _put_floor_sign(free, aisle, rng)


def _guard_columns(draft: SceneDraft) -> None:
    guard = catalog_object("column_guard")
    columns = [item for item in draft.instances if draft.models[item.model].class_name == "column"]
    for column in columns:
        # On the base plate, which is 30 mm thick.
        at = np.array([*column.T_world_object[:2, 3], 0.032 + guard.size[2] / 2])
        if not _is_blocked(at, float(guard.size[0]) / 2, draft, column):
            draft.add(guard, make_transform(translation=at))


def _is_blocked(at: np.ndarray, half: float, draft: SceneDraft, column: ObjectInstance) -> bool:
    """Return whether a collar around a column would stand in anything but it."""
    solids = draft.solids()
    reach = np.array([half, half, 0.5])
    near = solids.near(at - reach, at + reach)
    return bool((solids.owner[near] != column.instance_id).any())


def _guard_docks(draft: SceneDraft) -> None:
    """Put two bumpers below the sill of each dock, on the outer face of the wall."""
    model = catalog_object("dock_bumper")
    for item in list(draft.instances):
        if not item.model.startswith("dock_door"):
            continue
        T, size = item.T_world_object, draft.models[item.model].size
        for side in (-0.8, 0.8):
            draft.put(
                model, (side, size[1] / 2 + 0.2 + model.size[1] / 2 + 0.002, -T[2, 3] - 0.02 - model.size[2] / 2), T
            )


def _guard_gates(draft: SceneDraft, free: FreePlaces) -> None:
    """Put a bollard at each side of the drive-in doors."""
    model = catalog_object("bollard")
    for item in _gates(draft):
        size = draft.models[item.model].size
        for side in (-1.0, 1.0):
            at = np.array([side * (size[0] / 2 + 0.16), -size[1] / 2 - 0.35, (model.size[2] - size[2]) / 2])
            # Beside the frame: what is before a door stays free.
            free.add(model, item.T_world_object @ make_transform(translation=at), 0.01)


def _add_rails(free: FreePlaces, wall: Wall, aisle: Area) -> None:
    """Part a footway of 1.2 m along the wall behind the aisle from it, where the floor is free."""
    model = catalog_object("guard_rail")
    for along in np.arange(wall.low + 4.0, wall.high - 4.0, 2.0):
        pose = wall.pose(float(along), float(model.size[2]) / 2, float(model.size[1]))
        pose[1, 3] += 1.2
        if pose[1, 3] < aisle.y_min - 0.8:
            free.add(model, pose, 0.02)


def _add_signs(
    draft: SceneDraft, free: FreePlaces, walls: tuple[Wall, ...], roof: Roof, aisle: Area, rng: np.random.Generator
) -> None:
    exit_sign = catalog_object("exit_sign")
    for item in _gates(draft):
        size = draft.models[item.model].size
        draft.put(
            exit_sign,
            (0.0, (size[1] - exit_sign.size[1]) / 2 - 0.004, (size[2] + exit_sign.size[2]) / 2 + 0.1),
            item.T_world_object,
        )
    for wall in walls:
        list(free.along(wall, exit_sign, 2.6, rng, 1))
        list(free.along(wall, catalog_object("mandatory_sign"), 2.0, rng, 1))
    _hang_aisle_signs(draft, roof, aisle, rng)
    _notify_loads(draft)


def _hang_aisle_signs(draft: SceneDraft, roof: Roof, aisle: Area, rng: np.random.Generator) -> None:
    """Hang the aisle's number over both of its ends, on two rods from the girders."""
    model = catalog_object(str(rng.choice(list(AISLE_SIGNS))))
    top = min(roof.under_girders - 0.15, 5.2)
    if top < 3.2:
        return
    y = (aisle.y_min + aisle.y_max) / 2
    for x in (aisle.x_min + 0.2, aisle.x_max - 0.2):
        draft.put(model, (x, y, top - model.size[2] / 2), rotation=rotation_z(np.pi / 2))
        rods = hanging_rods(round(roof.height - top, 2))
        draft.put(rods, (x, y, top + rods.size[2] / 2), rotation=rotation_z(np.pi / 2))


def _notify_loads(draft: SceneDraft) -> None:
    """Hang the notice of safe loads on the outer frames of each row of racks, facing out of the row."""
    model = catalog_object("load_notice")
    if any(item.model.startswith(model.name) for item in draft.instances):
        return  # the layout has hung its own
    frames = [item for item in draft.instances if item.model.startswith("rack_frame")]
    rows: dict[float, list[ObjectInstance]] = {}
    for item in frames:
        rows.setdefault(round(float(item.T_world_object[1, 3]), 1), []).append(item)
    for row in rows.values():
        row.sort(key=lambda item: float(item.T_world_object[0, 3]))
        for item, side in ((row[0], -1.0), (row[-1], 1.0)):
            half = float((np.abs(item.T_world_object[:3, :3]) @ draft.models[item.model].size)[0]) / 2
            x, y = item.T_world_object[0, 3] + side * (half + 0.006), item.T_world_object[1, 3]
            draft.put(model, (x, y, _EYE), rotation=rotation_z(side * np.pi / 2))


def _add_fire_equipment(free: FreePlaces, walls: tuple[Wall, ...], rng: np.random.Generator) -> None:
    """Hang two extinguishers with their signs on each wall, and a hose cabinet on two of them."""
    extinguisher, sign, hose = (catalog_object(name) for name in ("extinguisher", "fire_sign", "fire_hose_cabinet"))
    for number, wall in enumerate(walls):
        for along in free.along(wall, extinguisher, 0.95, rng, 2):
            free.add(sign, wall.pose(along, 2.2, float(sign.size[1])), 0.02)
        if number % 2:
            list(free.along(wall, hose, 1.3, rng, 1))


def _paint_markings(draft: SceneDraft, aisle: Area, floor: Area) -> None:
    """Paint keep-clear fields before the gates, a crossing in the aisle and white lines along the walls."""
    keep, crossing = catalog_object("keep_clear_marking"), catalog_object("crossing_marking")
    for item in _gates(draft):
        size = draft.models[item.model].size
        draft.put(
            keep, (0.0, -size[1] / 2 - 0.3 - keep.size[1] / 2, (PAINT - size[2]) / 2 + _LIFT), item.T_world_object
        )
    if aisle.x_max + 2.6 < floor.x_max and aisle.y_max - aisle.y_min > 2.0:
        at = np.array([aisle.x_max + 1.4, (aisle.y_min + aisle.y_max) / 2, PAINT / 2 + 2 * _LIFT])
        draft.add(crossing, make_transform(rotation_z(np.pi / 2), at))
    line = catalog_object("lane_line_white_6000")
    for y in (floor.y_min + 1.5,):
        if y < aisle.y_min - 0.5:
            for x in np.arange(floor.x_min + 3.2, floor.x_max - 3.0, 6.0):
                draft.put(line, (x, y, PAINT / 2 + _LIFT))
    corner = catalog_object("corner_marking")
    # The legs of the mark run to +x and +y of its own frame: inward at each corner of the aisle.
    for x, y, turn in (
        (aisle.x_min, aisle.y_min, 0.0),
        (aisle.x_max, aisle.y_min, np.pi / 2),
        (aisle.x_max, aisle.y_max, np.pi),
        (aisle.x_min, aisle.y_max, -np.pi / 2),
    ):
        inward = rotation_z(turn) @ np.array([0.25, 0.25, 0.0])
        at = np.array([x, y, PAINT / 2 + 3 * _LIFT]) + inward
        draft.add(corner, make_transform(rotation_z(turn), at))


def _stick_labels(draft: SceneDraft, aisle: Area) -> None:
    """Stick a label with a barcode every 3 m along both edges of the aisle, read from its middle."""
    names = list(FLOOR_LABELS)
    for side, y in ((1.0, aisle.y_max - 0.25), (-1.0, aisle.y_min + 0.25)):
        for number, x in enumerate(np.arange(aisle.x_min + 1.2, aisle.x_max - 0.5, 3.0)):
            model = catalog_object(names[number % len(names)])
            draft.put(
                model, (x, y, float(model.size[2]) / 2 + 4 * _LIFT), rotation=rotation_z(0.0 if side > 0 else np.pi)
            )


def _put_floor_sign(free: FreePlaces, aisle: Area, rng: np.random.Generator) -> None:
    model = catalog_object("floor_sign")
    for _ in range(20):
        end = aisle.x_min if rng.random() < 0.5 else aisle.x_max
        x = end + rng.uniform(-1.5, 1.0) * (1.0 if end < 0 else -1.0)
        at = np.array([x, rng.uniform(aisle.y_min + 0.4, aisle.y_max - 0.4), float(model.size[2]) / 2])
        if free.add(model, make_transform(rotation_z(rng.uniform(-np.pi, np.pi)), at), 0.3):
            return


def _gates(draft: SceneDraft) -> list[ObjectInstance]:
    return [item for item in draft.instances if item.model.startswith("drive_in_door")]
