"""A trained detector of sweeps: a LiDAR's points in, boxes of their range image out, and the points of each object."""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Bool, Float

from warehouse_sim.errors import InputError
from warehouse_sim.estimators.api import Detector
from warehouse_sim.estimators.detectors.boxes import suppress
from warehouse_sim.estimators.detectors.estimator import MOST_DETECTIONS, DetectConfig
from warehouse_sim.estimators.image import Detection, RgbdImage, SweepView
from warehouse_sim.estimators.lidar.clusters import ClusterConfig, chosen_points, cluster
from warehouse_sim.estimators.lidar.projection import sparse_depth
from warehouse_sim.estimators.lidar.sweep.compose import MARGIN
from warehouse_sim.estimators.lidar.sweep.network import SweepNetwork, SweepRun
from warehouse_sim.estimators.lidar.sweep.range_image import Box, SweepGrid, in_box, on_turn, range_image
from warehouse_sim.estimators.lidar.sweep.rows import Plane, above_floor, floor_in, two_planes, up_of
from warehouse_sim.estimators.lidar.sweep.view import facing_points
from warehouse_sim.estimators.segmenters.cluster import FLOOR, FLOOR_FRACTION
from warehouse_sim.geometry.pose import Transform, invert, transform_points
from warehouse_sim.learning.compute import cpu_threads, place

_LEAST_LIKELY = 8
"""Points of a box that must show an object, that the others are left out."""
_LIKELY = ClusterConfig(min_eps=0.2, max_eps=0.4, min_points=5, min_points_few=3)
"""What makes a cluster of points that a network names: they are few, and mostly right."""


@dataclass(frozen=True, eq=False)
class SweepDetection(Detection):
    """A detection that a sweep was looked at for."""

    own: Bool[np.ndarray, " n"] = field(default_factory=lambda: np.zeros(0, dtype=bool))
    """Which points of the sweep are the object's."""


@dataclass(frozen=True, eq=False)
class FoundInSweep:
    """One object that was found in a sweep."""

    box: Box
    """Left, top, right, bottom of edges of the range image (px)."""
    score: float
    """Trust in it, 0-1."""
    class_name: str
    """Its class; empty where ``model`` says more."""
    model: str | None = None
    """Name of its geometry, where the detector tells geometries apart."""
    likely: Bool[np.ndarray, " n"] | None = None
    """Which points of the sweep show an object of any kind; None if not stated."""


def facing(grid: SweepGrid, box: Box, up: Float[np.ndarray, " 3"]) -> Transform:
    """Return T_lidar_view of the level frame (x right, y down, z ahead) that looks at a box; see ``facing_points``."""
    middle = [(box[0] + box[2]) / 2.0, (box[1] + box[3]) / 2.0]
    return facing_points(grid.directions(np.array([middle])), up)


def own_points(
    points: Float[np.ndarray, "n 3"],
    grid: SweepGrid,
    box: Box,
    T_lidar_view: Transform,
    floor: Plane | None,
    likely: Bool[np.ndarray, " n"] | None = None,
) -> Bool[np.ndarray, " n"]:
    """Return which points of a sweep are the object's in a box: a dense near cluster of what is likely its own.

    Where nothing is known to be likely, that is what lies above the floor.

    Args:
        points: LiDAR frame (m).
        grid: Of the box.
        box: Where it is.
        T_lidar_view: The frame that looks at it, along which clusters reach farther with the distance.
        floor: Plane of the floor; None where it is unknown, and all points may be the object's.
        likely: Which points show an object, as far as a detector can tell; where it names next to none in the box,
            nothing is made of it. None if not stated.
    """
    inside = np.flatnonzero(in_box(grid, points, box))
    clusters = ClusterConfig()
    if likely is not None and likely[inside].sum() >= _LEAST_LIKELY:
        # The network knows the floor better than a height does: lower boards lie on it.
        inside, clusters = inside[likely[inside]], _LIKELY
    elif floor is not None:
        least = FLOOR + FLOOR_FRACTION * np.linalg.norm(points[inside], axis=1)
        inside = inside[above_floor(points[inside], floor) > least]
    own = np.zeros(len(points), dtype=bool)
    if len(inside):
        seen = transform_points(invert(T_lidar_view), points[inside])
        area = (box[2] - box[0]) / grid.columns_per_rad * (box[3] - box[1]) / grid.rows_per_rad
        spacing = float(np.sqrt(area / len(inside)))
        own[inside] = chosen_points(seen, cluster(seen, spacing, clusters))
    return own


_LEAST_SEEN = 0.3
"""Fraction of an object's points that a camera must see, that the object is one of its image."""
_LEAST_FREE = 0.5
"""Fraction of an object's points that no better detection has taken."""
UPWARDS = np.array([0.0, 0.0, 1.0])
"""Against gravity, where no floor says better: a LiDAR's z axis is taken for vertical, as KITTI's readers do."""


class TrainedSweepDetector(Detector):
    """The detector of a run folder.

    Args:
        run: Run folder, or folder of a bundled model.
        config: What counts as found.

    Raises:
        TrainingError: The folder holds no complete run of a detector of sweeps.
    """

    reads_sweep = True
    reads_rgb = False

    def __init__(self, run: Path, config: DetectConfig = DetectConfig(min_score=0.25)) -> None:  # noqa: B008  frozen
        self.run_config, self.config = SweepRun.read(run), config
        self._network: SweepNetwork = self.run_config.load_network(run)
        self._device, self._threads = place(self._network, config.device, config.threads)
        self.grid = SweepGrid(self.run_config.images)
        """Of the boxes."""

    @property
    def classes(self) -> tuple[str, ...]:
        """The classes that it distinguishes."""
        return self.run_config.classes

    def find(self, points: Float[np.ndarray, "n 3"]) -> tuple[list[FoundInSweep], Plane | None]:
        """Return what is found all around, the best first, and the floor.

        Args:
            points: A sweep (LiDAR frame, m), in any order.
        """
        points = np.asarray(points, dtype=float)
        floor = floor_in(points)
        return self.find_above(points, floor), floor

    @torch.inference_mode()
    def find_above(self, points: Float[np.ndarray, "n 3"], floor: Plane | None) -> list[FoundInSweep]:
        """Return what is found all around, the best first, where the floor is known, or known to be unknown."""
        image = range_image(points, self.grid)
        planes = two_planes(image, points, floor)
        # Both ends are seen whole: what lies across one is found in the margin of the other.
        turn = np.concatenate([planes[..., -MARGIN:], planes, planes[..., :MARGIN]], axis=2)
        seen = torch.from_numpy(turn)[None].to(self._device)
        with cpu_threads(self._threads):
            raw = self._network(None, seen)
            boxes, scores = self._network.decode(raw)
        likely = self._shown(points, raw.pixels[0, :, MARGIN:-MARGIN].cpu().numpy() > 0.0)
        config, columns = self.config, self.grid.config.columns
        kept = suppress(
            boxes[0].cpu().double().numpy(), scores[0].cpu().double().numpy(), config.min_score, config.max_overlap,
            2 * MOST_DETECTIONS,
        )  # fmt: skip
        by_object, found = self.run_config.train.labels == "object", list[FoundInSweep]()
        for box, score, number in zip(kept.boxes - np.array([MARGIN, 0] * 2), kept.scores, kept.classes, strict=True):
            box[[1, 3]] = np.clip(box[[1, 3]], 0.0, self.grid.config.rows)
            # What lies in a margin was found in its own place, too.
            if 0.0 <= (box[0] + box[2]) / 2.0 < columns and box[2] > box[0] and box[3] > box[1]:
                name = self.classes[int(number)]
                class_name, model = ("", name) if by_object else (name, None)
                found.append(FoundInSweep(on_turn(box, columns), float(score), class_name, model, likely))
        return found[:MOST_DETECTIONS]

    def _shown(self, points: Float[np.ndarray, "n 3"], pixels: Bool[np.ndarray, "h w"]) -> Bool[np.ndarray, " n"]:
        """Return which points lie in some pixels."""
        u, v = self.grid.pixels(points).T
        return np.asarray((v >= 0) & pixels[v, u])

    def detect(self, image: RgbdImage) -> list[SweepDetection]:
        """Return what of it an image's camera sees, each by the box about its points there, the best first.

        Raises:
            InputError: The image comes without a sweep.
        """
        sweep, seen = require_sweep(image), list[SweepDetection]()
        for item in self.around(sweep.points):
            points = transform_points(sweep.T_camera_lidar, sweep.points[item.own])
            shown = sparse_depth(image.camera, points).shown
            v, u = np.nonzero(shown >= 0)
            # Of what is cut by the image's border most must be in it.
            if len(v) and np.isin(np.arange(len(points)), shown[v, u]).mean() > _LEAST_SEEN:
                box = (float(u.min()), float(v.min()), float(u.max()), float(v.max()))
                seen.append(replace(item, box_xyxy=box))
        return seen

    def around(self, points: Float[np.ndarray, "n 3"]) -> list[SweepDetection]:
        """Return what is found all around a LiDAR, each with its points, the best first.

        A point is one object's: what would be made mostly of points of better detections is left out. ``box_xyxy`` is
        in pixels of the range image, whatever camera there is.

        Args:
            points: A sweep (LiDAR frame, m), in any order.
        """
        found, floor = self.find(points)
        up, detections = UPWARDS if floor is None else up_of(floor), list[SweepDetection]()
        taken = np.zeros(len(points), dtype=bool)
        for item in found:
            own = own_points(points, self.grid, item.box, facing(self.grid, item.box, up), floor, item.likely)
            free = own & ~taken
            if free.sum() > _LEAST_FREE * own.sum():
                own, taken = free, taken | free
                left, top, right, bottom = (item.box - 0.5).tolist()
                box = (left, top, right, bottom)
                detections.append(
                    SweepDetection(None, item.model, item.score, None, box, class_name=item.class_name, own=own)
                )
        return detections


def require_sweep(image: RgbdImage) -> SweepView:
    """Return the sweep of an image.

    Raises:
        InputError: It comes without one.
    """
    if image.sweep is None:
        raise InputError("the image comes without a LiDAR's sweep, which is what is looked at: give RgbdImage.sweep")
    return image.sweep
