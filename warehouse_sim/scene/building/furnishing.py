"""What hangs on walls and stands or is painted beside ways: signs, fire equipment, guards, markings, labels, bins."""

from collections.abc import Sequence

import numpy as np

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.building.floor_marks import PAINT
from warehouse_sim.catalog.building.safety import AISLE_SIGNS, FLOOR_LABELS
from warehouse_sim.catalog.building.to_size import hanging_rods
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import make_transform, rotation_z
from warehouse_sim.scene.building.free_places import FreePlaces, Wall, walls_of
from warehouse_sim.scene.building.services import Roof, ServicesConfig
from warehouse_sim.scene.draft import Area, SceneDraft
from warehouse_sim.schema import ObjectInstance

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
            at = np.array([side, size[1] / 2 + 0.2 + model.size[1] / 2 + 0.002, -T[2, 3] - 0.02 - model.size[2] / 2])
            draft.add(model, T @ make_transform(translation=at))


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
        at = np.array([0.0, (size[1] - exit_sign.size[1]) / 2 - 0.004, (size[2] + exit_sign.size[2]) / 2 + 0.1])
        draft.add(exit_sign, item.T_world_object @ make_transform(translation=at))
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
    for x in (aisle.x_min + 0.2, aisle.x_max - 0.2):
        at = np.array([x, (aisle.y_min + aisle.y_max) / 2, top - model.size[2] / 2])
        draft.add(model, make_transform(rotation_z(np.pi / 2), at))
        rods = hanging_rods(round(roof.height - top, 2))
        at = np.array([x, at[1], top + rods.size[2] / 2])
        draft.add(rods, make_transform(rotation_z(np.pi / 2), at))


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
            draft.add(model, make_transform(rotation_z(side * np.pi / 2), np.array([x, y, _EYE])))


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
        at = np.array([0.0, -size[1] / 2 - 0.3 - keep.size[1] / 2, (PAINT - size[2]) / 2 + _LIFT])
        draft.add(keep, item.T_world_object @ make_transform(translation=at))
    if aisle.x_max + 2.6 < floor.x_max and aisle.y_max - aisle.y_min > 2.0:
        at = np.array([aisle.x_max + 1.4, (aisle.y_min + aisle.y_max) / 2, PAINT / 2 + 2 * _LIFT])
        draft.add(crossing, make_transform(rotation_z(np.pi / 2), at))
    line = catalog_object("lane_line_white_6000")
    for y in (floor.y_min + 1.5,):
        if y < aisle.y_min - 0.5:
            for x in np.arange(floor.x_min + 3.2, floor.x_max - 3.0, 6.0):
                draft.add(line, make_transform(translation=np.array([x, y, PAINT / 2 + _LIFT])))
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
            at = np.array([x, y, float(model.size[2]) / 2 + 4 * _LIFT])
            draft.add(model, make_transform(rotation_z(0.0 if side > 0 else np.pi), at))


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
