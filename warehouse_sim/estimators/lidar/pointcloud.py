"""``detect-pointcloud``: poses from a LiDAR alone. Boxes of its depth image, clusters, so many points, a network.

The chain of Coimbra (2023); where images bring boxes or masks these are taken, else a detector's.
"""

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float
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

_MOST_A_CENTRE = 8
"""Of larger clouds so many points for each centre decide where the centres lie."""


def resample(points: Float[np.ndarray, "n 3"], count: int, rng: np.random.Generator) -> Float[np.ndarray, "count 3"]:
    """Return exactly ``count`` points for a cloud, in random order: of more points the centres of clusters.

    Args:
        points: At least one (m); of fewer than ``count``, all are kept and some repeated.
        count: How many are wanted.
        rng: Source of randomness.
    """
    present = len(points)
    if not present:
        raise ValueError("a cloud without points cannot be resampled")
    if present <= count:
        numbers = np.concatenate([np.arange(present), rng.integers(present, size=count - present)])
        return points[rng.permutation(numbers)]
    return kmeans_centres(points, count, rng)[rng.permutation(count)]


def kmeans_centres(
    points: Float[np.ndarray, "n 3"], count: int, rng: np.random.Generator, steps: int = 10
) -> Float[np.ndarray, "count 3"]:
    """Return the centres of exactly ``count`` clusters (Lloyd 1982), none of which is empty.

    Centres of curved or bent surfaces lie beside them.

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


class PointChain(Pipeline):
    """The stages of a network that reads points alone, on objects' points that become as many as it takes.

    Args:
        network: The network's own chain.
        detect: What finds detections first.
    """

    def __init__(self, network: Estimator, detect: Sequence[FindDetections] = ()) -> None:
        self._network = network
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
        chosen = resample(points, self._network.point_count, rng)
        nothing = np.zeros(len(chosen))
        return replace(
            crop, points=chosen.astype(np.float32), border_px=nothing.astype(np.uint8), pixel=nothing.astype(np.int32)
        )


class LidarChain(PointChain):
    """Clusters of boxes, resampled, for a network that reads points alone; see ``PointChain`` for the arguments."""

    depth_source: DepthSource = "lidar"
    reads_rgb = False

    def __init__(self, network: Estimator, detect: Sequence[FindDetections] = ()) -> None:
        super().__init__(network, (*detect, BoxClusters()))

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
