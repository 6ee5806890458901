"""``detect-pointcloud``: poses from a LiDAR alone. Boxes of its depth image, clusters, so many points, a network.

The chain of Coimbra (2023); where images bring boxes or masks these are taken, else a detector's.
"""

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from jaxtyping import Float, Int
from scipy.spatial import cKDTree

from warehouse_sim.errors import InputError
from warehouse_sim.estimators.api import Composition, LeastVisible, PoseEstimator
from warehouse_sim.estimators.detections import open_stages
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.load import load_estimator
from warehouse_sim.estimators.pipeline import FindDetections, ObjectPoints, Pipeline, WithFrontEnd
from warehouse_sim.estimators.pose.densefusion.crops.cut import Crop
from warehouse_sim.estimators.pose.densefusion.estimator import Estimator
from warehouse_sim.estimators.segmenters.cluster import BoxClusters, detection_points
from warehouse_sim.estimators.settings import DepthSource, PredictConfig
from warehouse_sim.resources import model_names

Resampling = Literal["kmeans", "farthest", "random"]
_MOST_A_CENTRE = 8
"""Of larger clouds so many points for each centre decide where the centres lie."""
_MOST_A_POINT = 32
"""Of larger clouds so many points for each that is wanted may be taken."""


def resample(
    points: Float[np.ndarray, "n 3"], count: int, method: Resampling, rng: np.random.Generator
) -> Float[np.ndarray, "count 3"]:
    """Return exactly ``count`` points of a cloud, in random order.

    Args:
        points: At least one (m).
        count: How many are wanted.
        method: What is done with more points than that; with fewer, all are kept and some repeated.
        rng: Source of randomness.
    """
    if not len(points):
        raise ValueError("a cloud without points cannot be resampled")
    if len(points) <= count:
        return points[rng.permutation(fill_up(len(points), count, rng))]
    if method == "kmeans":
        return kmeans_centres(points, count, rng)[rng.permutation(count)]
    if method == "farthest":
        return points[rng.permutation(farthest_points(points, count, rng))]
    return points[rng.permutation(len(points))[:count]]


def fill_up(present: int, count: int, rng: np.random.Generator) -> Int[np.ndarray, " count"]:
    """Return numbers below ``present``, each once, and random ones with replacement up to ``count``."""
    return np.concatenate([np.arange(present), rng.integers(present, size=count - present)])


def kmeans_centres(
    points: Float[np.ndarray, "n 3"], count: int, rng: np.random.Generator, steps: int = 10
) -> Float[np.ndarray, "count 3"]:
    """Return the centres of exactly ``count`` clusters (Lloyd 1982), none of which is empty.

    Centres of curved or bent surfaces lie beside them: ``farthest_points`` returns points that were measured.

    Args:
        points: More than ``count`` (m).
        count: Of the centres.
        rng: Decides where they start, and which points of a large cloud decide.
        steps: Most steps; fewer where nothing moves any more.
    """
    if len(points) > _MOST_A_CENTRE * count:
        points = points[rng.permutation(len(points))[: _MOST_A_CENTRE * count]]
    centres = np.asarray(points[rng.permutation(len(points))[:count]], dtype=float)
    for _ in range(steps):
        distance, owner = cKDTree(centres).query(points)
        size = np.bincount(owner, minlength=count)
        sums = np.stack([np.bincount(owner, points[:, axis], count) for axis in range(3)], axis=1)
        moved = sums / np.maximum(size, 1)[:, None]
        empty = np.flatnonzero(size == 0)
        # Where two centres began at one place, one of them goes to the point that is worst off.
        moved[empty] = points[np.argsort(-distance)[: len(empty)]]
        still = np.abs(moved - centres).max() < 1e-6
        centres = moved
        if still:
            break
    return centres


def farthest_points(
    points: Float[np.ndarray, "n 3"], count: int, rng: np.random.Generator
) -> Int[np.ndarray, " count"]:
    """Return the numbers of points each of which is farthest from those before it (Gonzalez 1985), from a random one.

    Args:
        points: At least ``count`` (m).
        count: How many are wanted.
        rng: Decides which is the first, and which points of a large cloud may be taken.
    """
    allowed = np.arange(len(points))
    if len(points) > _MOST_A_POINT * count:
        allowed = rng.permutation(len(points))[: _MOST_A_POINT * count]
    cloud = np.ascontiguousarray((points[allowed] - points[allowed[0]]).T, dtype=np.float32)
    x, y, z = cloud
    taken, nearest = np.empty(count, np.int64), np.full(len(allowed), np.inf, np.float32)
    taken[0] = rng.integers(len(allowed))
    for step in range(1, count):
        last = taken[step - 1]
        distance = np.square(x - x[last]) + np.square(y - y[last]) + np.square(z - z[last])
        np.minimum(nearest, distance, out=nearest)
        nearest[last] = -1.0
        taken[step] = nearest.argmax()
    return np.asarray(allowed[taken])


class PointChain(Pipeline):
    """The stages of a network that reads points alone, on objects' points that become as many as it takes.

    Args:
        network: The network's own chain.
        detect: What finds detections first.
        resampling: How an object's points become a fixed number.
    """

    def __init__(
        self, network: Estimator, detect: Sequence[FindDetections] = (), resampling: Resampling = "kmeans"
    ) -> None:
        self._network, self._resampling = network, resampling
        super().__init__(replace(network.stages, detect=tuple(detect), select=self._select), network.objects)

    @property
    def min_visible(self) -> LeastVisible:
        """Which of a dataset's targets it takes."""
        return self._network.min_visible

    @abstractmethod
    def points_of(self, image: RgbdImage, crop: Crop) -> tuple[Float[np.ndarray, "n 3"], list[int]]:
        """Return the points (m) that are the object's, and what the seed of their choice ends with."""

    def _select(self, image: RgbdImage) -> list[ObjectPoints]:
        return [self._resampled(image, crop) for crop in self._network.cut(image)]

    def _resampled(self, image: RgbdImage, crop: Crop) -> Crop:
        if crop.around is not None:
            # Points beside the mask, each with what is known of it, are drawn by the network's own rules.
            return crop
        points, place = self.points_of(image, crop)
        rng = np.random.default_rng([self._network.config.seed, image.scene_id, image.image_id, *place])
        chosen = resample(points, self._network.point_count, self._resampling, rng)
        nothing = np.zeros(len(chosen))
        return replace(
            crop, points=chosen.astype(np.float32), border_px=nothing.astype(np.uint8), pixel=nothing.astype(np.int32)
        )


class LidarChain(PointChain):
    """Clusters of boxes, resampled, for a network that reads points alone; see ``PointChain`` for the arguments."""

    depth_source: DepthSource = "lidar"
    reads_rgb = False

    def __init__(
        self, network: Estimator, detect: Sequence[FindDetections] = (), resampling: Resampling = "kmeans"
    ) -> None:
        super().__init__(network, (*detect, BoxClusters()), resampling)

    def points_of(self, image: RgbdImage, crop: Crop) -> tuple[Float[np.ndarray, "n 3"], list[int]]:
        """Return the points of its detection."""
        return detection_points(image, image.detections[crop.position]).points, [crop.position]


def point_network(name: str, config: PredictConfig) -> Estimator:
    """Return a bundled network that reads points alone, without uncertainty, which was fitted for other inputs.

    Raises:
        InputError: The network reads an image, or ``config`` rejects by uncertainty.
    """
    if config.reject is not None or config.reject_blocked:
        raise InputError("no uncertainty was fitted for what LiDAR chains estimate; leave --reject out")
    network = load_estimator(name, replace(config, uncertainty=False))
    if not isinstance(network, Estimator) or network.crop.side_px is not None:
        raise InputError(f"{name} reads an image; a LiDAR alone has none")
    return network


@dataclass(frozen=True)
class LidarMethod(Composition):
    """What a name of ``ESTIMATORS`` stands for: a bundled network behind the LiDAR's front end."""

    front_end: str
    """Finds objects in depth made of sweeps; where it has no bundled weights, detections are to be given."""
    estimator: str
    """The network, which must read points alone."""
    inputs = "LiDAR: boxes, clusters, cloud"

    def configured(self, config: PredictConfig) -> PoseEstimator:
        """Return the estimator.

        Raises:
            InputError: The network reads an image, or uncertainty was fitted for it alone.
        """
        chain = LidarChain(point_network(self.estimator, config))
        if self.front_end not in model_names():
            return chain
        return WithFrontEnd(chain, open_stages(self.front_end), config.objects)


DETECT_POINTCLOUD = LidarMethod("detector-lidar", "densefusion-pointcloud")
