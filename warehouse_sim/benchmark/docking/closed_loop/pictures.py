"""Approaches from above: what stands there, the ways that were driven, and where the tines went in."""

from pathlib import Path

import cv2
import numpy as np
from jaxtyping import Float, UInt8

from warehouse_sim.benchmark.docking.closed_loop.drive import Approach
from warehouse_sim.benchmark.docking.closed_loop.run import Runner
from warehouse_sim.benchmark.docking.closed_loop.starts import Start
from warehouse_sim.evaluation.docking.fork import HEEL_GAP, REACH, TINE_WIDTH
from warehouse_sim.geometry.boxes import OrientedBox, box_corners
from warehouse_sim.geometry.pose import Transform, invert, transform_points
from warehouse_sim.scene.solids import Solids
from warehouse_sim.scene.viewpoints.vehicles import FORKLIFT, pose_on_floor

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
