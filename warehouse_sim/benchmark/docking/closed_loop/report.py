"""What a run came to: a row for each level and method, with intervals over scenes; and approaches drawn from above."""

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from jaxtyping import Float, UInt8

from warehouse_sim.benchmark.docking.closed_loop.drive import ABORTS, Approach
from warehouse_sim.benchmark.docking.closed_loop.episode import Row
from warehouse_sim.benchmark.docking.closed_loop.run import LEFT_OUT, Runner
from warehouse_sim.benchmark.docking.closed_loop.starts import Start
from warehouse_sim.benchmark.docking.record import over_scenes
from warehouse_sim.evaluation.docking.fork import HEEL_GAP, REACH, TINE_WIDTH
from warehouse_sim.geometry.boxes import OrientedBox, box_corners
from warehouse_sim.geometry.pose import Transform, invert, transform_points
from warehouse_sim.scene.solids import Solids
from warehouse_sim.scene.viewpoints.mountings import FORKLIFT, pose_on_floor

DOCKED = "docked"
_DEG = 180.0 / np.pi
_UNITS = (("lateral", "mm", 1e3), ("depth", "mm", 1e3), ("vertical", "mm", 1e3), ("yaw", "deg", _DEG))


def by_level(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Return for each level and method: the fraction that docks, how the others end, and what the approach took.

    Args:
        rows: Of one or more recipes. What was left out is counted beside, no part of the fraction.
    """
    groups: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        groups.setdefault((row["condition"], row["method"]), []).append(row)
    return [_summary(f"{condition}, {method}", found) for (condition, method), found in groups.items()]


def _summary(name: str, rows: Sequence[Row]) -> dict[str, Any]:
    left_out = sum(row["outcome"] == LEFT_OUT for row in rows)
    rows = [row for row in rows if row["outcome"] != LEFT_OUT]
    if not rows:
        return {"name": name, "value": 0.0, "episodes": 0, "left_out": left_out}
    docked = np.array([row["outcome"] == DOCKED for row in rows], dtype=float)
    arrived = [row for row in rows if "errors" in row]
    outcomes = Counter(row["outcome"] for row in rows)
    return {
        "name": name,
        "factor": rows[0]["factor"],
        "value": float(docked.mean()),
        "interval": over_scenes(rows, docked),
        "episodes": len(rows),
        "scenes": len({(row["source"], row["scene"]) for row in rows}),
        "left_out": left_out,
        "aborted": sum(outcomes[reason] for reason in ABORTS),
        "outcomes": dict(outcomes.most_common()),
        "swept-volume check docks": float(np.mean([bool(row.get("swept", {}).get("docks")) for row in rows])),
        "median_time_s": float(np.median([row["time"] for row in rows])),
        "median_distance_m": float(np.median([row["distance"] for row in rows])),
        "median_images": float(np.median([row["images"] for row in rows])),
        "mean_corrections": float(np.mean([row["corrections"] for row in rows])),
        **_errors(arrived),
        **({"cpu_s": float(np.mean(seconds))} if (seconds := [row["cpu_s"] for row in rows if "cpu_s" in row]) else {}),
    }


def _errors(arrived: Sequence[Row]) -> dict[str, float]:
    """Return median and greatest final errors of those that went in (mm, deg)."""
    if not arrived:
        return {}
    found = {}
    for name, unit, factor in _UNITS:
        values = np.abs([row["errors"][name] for row in arrived]) * factor
        found[f"median_{name}_{unit}"] = float(np.median(values))
        found[f"worst_{name}_{unit}"] = float(values.max())
    return found


def table(summaries: Sequence[dict[str, Any]]) -> list[str]:
    """Return the summaries as lines of a Markdown table."""
    lines = [
        "| level, method | docked (95 % over scenes) | episodes | aborted | other ends | lateral, yaw (median) | s | corrections |",  # noqa: E501
        "|---|---|---|---|---|---|---|---|",
    ]
    for row in summaries:
        if not row["episodes"]:
            lines.append(f"| {row['name']} | - | 0 ({row['left_out']} left out) | | | | | |")
            continue
        low, high = row["interval"]
        ends = ", ".join(f"{name} {count}" for name, count in row["outcomes"].items() if name != DOCKED) or "none"
        errors = (
            f"{row['median_lateral_mm']:.0f} mm, {row['median_yaw_deg']:.2f} deg" if "median_yaw_deg" in row else ""
        )
        left = f" ({row['left_out']} left out)" if row["left_out"] else ""
        docked = f"{100 * row['value']:.0f} % [{100 * low:.0f}, {100 * high:.0f}]"
        lines.append(
            f"| {row['name']} | {docked} | {row['episodes']}{left} "
            f"| {row['aborted']} | {ends} | {errors} | {row['median_time_s']:.0f} | {row['mean_corrections']:.1f} |"
        )
    return lines


_PIXELS, _MARGIN = 110.0, 1.4
"""Pixels a metre, and how much is drawn around the start and the pallet (m)."""
_COLOURS = ((40, 40, 40), (30, 110, 240), (200, 90, 20), (60, 160, 60), (150, 40, 160))
_LOW, _HIGH = 0.05, 2.3
"""What lies between these heights (m) is drawn."""


def picture(path: Path, runner: Runner, scene: int, number: int) -> None:
    """Drive a start once more by every method under the first level, and draw all of it.

    Args:
        path: PNG file.
        runner: Of the recipe.
        scene: Which scene.
        number: Which of its starts.
    """
    condition = runner.conditions[0]
    driven = [(method, *runner.approach(scene, number, condition, method)) for method in runner.methods]
    start = driven[0][3]
    sheet = _Sheet(start)
    for (method, row, approach, _), colour in zip(driven, _COLOURS, strict=False):
        sheet.way(approach, colour)
        sheet.line(f"{method}: {row['outcome']}, {row['time']:.0f} s, {row['corrections']} corrections", colour)
        if approach.T_world_dock is not None:
            sheet.tines(approach.T_world_dock, start, colour)
    path.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(path), sheet.image)


class _Sheet:
    """A plan around a start; up is into the pallet."""

    def __init__(self, start: Start) -> None:
        T_world_dock = start.pallet.T_world_object @ start.face.T_object_dock
        yaw = float(np.arctan2(T_world_dock[1, 0], T_world_dock[0, 0]))
        self._T_plan_world = invert(pose_on_floor(T_world_dock[0, 3], T_world_dock[1, 3], yaw))
        truck = transform_points(self._T_plan_world, np.array([[start.pose.x, start.pose.y, 0.0]]))[0]
        low = np.minimum(truck[:2], [0.0, -1.0]) - [_MARGIN - FORKLIFT.rear, _MARGIN]
        high = np.maximum(truck[:2], [1.3, 1.0]) + _MARGIN
        self._low, self._high = low, high
        height, width = np.ceil((high - low) * _PIXELS).astype(int)
        self.image: UInt8[np.ndarray, "h w 3"] = np.full((height, width, 3), 255, np.uint8)
        self._lines = 0
        self._scene(start)
        self._body(pose_on_floor(start.pose.x, start.pose.y, start.pose.yaw))

    def _scene(self, start: Start) -> None:
        scene = start.station.scene
        solids = Solids.of(scene.instances, scene.models)
        near = solids.near(*self._bounds())
        for owner, box in zip(solids.owner[near], solids.listed(near), strict=True):
            mine = int(owner) == start.pallet.instance_id
            loaded = any(int(owner) == item.instance_id for item in start.station.load)
            if not loaded:
                self._box(box, (110, 170, 215) if mine else (215, 215, 215))

    def _bounds(self) -> tuple[Float[np.ndarray, " 3"], Float[np.ndarray, " 3"]]:
        corners = np.array([[x, y, 0.0] for x in (self._low[0], self._high[0]) for y in (self._low[1], self._high[1])])
        world = transform_points(invert(self._T_plan_world), corners)
        return np.array([*world.min(axis=0)[:2], _LOW]), np.array([*world.max(axis=0)[:2], _HIGH])

    def _pixels(self, points: Float[np.ndarray, "n 3"]) -> np.ndarray:
        plan = transform_points(self._T_plan_world, points)[:, :2]
        return np.round(np.stack([self._high[1] - plan[:, 1], self._high[0] - plan[:, 0]], axis=1) * _PIXELS).astype(
            np.int32
        )

    def _box(self, box: OrientedBox, colour: tuple[int, int, int]) -> None:
        corners = transform_points(box.T_parent_box, box_corners(box.size))
        outline = cv2.convexHull(self._pixels(corners))
        cv2.fillConvexPoly(self.image, outline, colour, cv2.LINE_AA)
        cv2.polylines(self.image, [outline], True, (150, 150, 150), 1, cv2.LINE_AA)

    def _body(self, T_world_vehicle: Transform) -> None:
        for box in FORKLIFT.boxes(T_world_vehicle):
            outline = cv2.convexHull(self._pixels(transform_points(box.T_parent_box, box_corners(box.size))))
            cv2.polylines(self.image, [outline], True, (0, 0, 0), 2, cv2.LINE_AA)

    def way(self, approach: Approach, colour: tuple[int, int, int]) -> None:
        """Draw where the middle between the tips went."""
        tips = np.array(
            [
                [pose.x + FORKLIFT.tip * np.cos(pose.yaw), pose.y + FORKLIFT.tip * np.sin(pose.yaw), 0.0]
                for pose in approach.way
            ]
        )
        cv2.polylines(self.image, [self._pixels(tips)], False, colour, 2, cv2.LINE_AA)

    def tines(self, T_world_dock: Transform, start: Start, colour: tuple[int, int, int]) -> None:
        """Draw the outlines of the tines where they stop."""
        for pocket in start.face.pockets:
            aside = (invert(start.face.T_object_dock) @ pocket.T_object_pocket)[1, 3]
            ends = [-HEEL_GAP, REACH]
            corners = [[x, aside + side, 0.0] for x in ends for side in (-TINE_WIDTH / 2, TINE_WIDTH / 2)]
            outline = cv2.convexHull(self._pixels(transform_points(T_world_dock, np.array(corners))))
            cv2.polylines(self.image, [outline], True, colour, 2, cv2.LINE_AA)

    def line(self, text: str, colour: tuple[int, int, int]) -> None:
        """Write a line at the foot."""
        self._lines += 1
        place = (10, self.image.shape[0] - 22 * self._lines)
        cv2.putText(self.image, text, place, cv2.FONT_HERSHEY_SIMPLEX, 0.5, colour, 1, cv2.LINE_AA)
