"""What is on the floor: painted lines, tyre marks, tracks, stains, patches and water."""

from collections.abc import Sequence

import numpy as np

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.building.floor_marks import PAINT, STAINS, VARIANTS, floor_stain, tyre_tracks
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z
from warehouse_sim.scene.draft import QUARTER_TURN, Area, SceneDraft

_LIFT = 0.0003
"""Height of the lowest film above the floor, and of each above the one before it (m)."""

_, _CURVE = _TYRE_MARKS = ("tyre_mark_straight", "tyre_mark_curve")
"""Straight ones lie along the aisle, bends any way."""
_LINE_LENGTHS = (6.0, 3.0, 1.0)


def wear_floor(draft: SceneDraft, counts: dict[str, int], area: Area, rng: np.random.Generator) -> None:
    """Leave ``counts`` of "tracks", "stain", "patch" and "water" on the floor of ``area``."""
    z = _LIFT
    for kind in ("patch", "stain", "water"):
        for _ in range(counts[kind]):
            model = floor_stain(next(item for item in STAINS if item == kind), int(rng.integers(VARIANTS)))
            x, y = rng.uniform(area.x_min, area.x_max), rng.uniform(area.y_min, area.y_max)
            turn = 0.0 if kind == "patch" else rng.uniform(-np.pi, np.pi)
            draft.put(model, (x, y, z + model.size[2] / 2), rotation=rotation_z(turn))
            z += 0.00002
    if counts["tracks"]:
        length, width = round(area.x_max - area.x_min, 1), round(area.y_max - area.y_min, 1)
        model = tyre_tracks(length, width, counts["tracks"], int(rng.integers(VARIANTS)))
        draft.put(model, ((area.x_min + area.x_max) / 2, (area.y_min + area.y_max) / 2, z + model.size[2] / 2))


def add_tyre_marks(draft: SceneDraft, count: int, area: Area, rng: np.random.Generator) -> None:
    """Leave tyre marks on the floor of ``area``."""
    for _ in range(count):
        name = str(rng.choice(_TYRE_MARKS))
        x, y = rng.uniform(area.x_min, area.x_max), rng.uniform(area.y_min, area.y_max)
        yaw = rng.uniform(-np.pi, np.pi) if name == _CURVE else rng.normal(0.0, 0.15)
        # Each a little higher than the one before, so that crossing marks do not share a plane.
        z = catalog_object(name).size[2] / 2 + 0.0001 * (1 + rng.random())
        draft.put(name, (x, y, z), rotation=rotation_z(yaw))


def mark_line(
    draft: SceneDraft, T_world_side: Transform, start: Sequence[float], length: float, along: str, colour: str
) -> None:
    """Paint a line from ``start`` (x, y in a side's frame, m) in the direction of its "x" or "y" axis.

    Lines come in lengths of 6, 3 and 1 m; what is left at the end stays bare.
    """
    direction = np.array([1.0, 0.0, 0.0]) if along == "x" else np.array([0.0, 1.0, 0.0])
    rotation = None if along == "x" else QUARTER_TURN
    at, rest = np.array([start[0], start[1], PAINT / 2]), length
    for piece in _LINE_LENGTHS:
        while rest >= piece - 1e-6:
            T_side_line = make_transform(rotation, at + direction * piece / 2)
            draft.add(f"lane_line_{colour}_{round(1000 * piece)}", T_world_side @ T_side_line)
            at, rest = at + direction * piece, rest - piece
