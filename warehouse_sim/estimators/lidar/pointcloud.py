"""``detect-pointcloud``: poses from a LiDAR alone. Boxes of its depth image, clusters, so many points, a network.

The chain of Coimbra (2023); where images bring boxes or masks these are taken, else a detector's.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from warehouse_sim.errors import InputError
from warehouse_sim.estimators.api import Composition, DepthSource, LeastVisible, PoseEstimator
from warehouse_sim.estimators.detections import open_stages
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.lidar.resample import Resampling, resample
from warehouse_sim.estimators.load import load_estimator
from warehouse_sim.estimators.pipeline import FindDetections, ObjectPoints, Pipeline, WithFrontEnd
from warehouse_sim.estimators.pose.densefusion.crops.cut import Crop
from warehouse_sim.estimators.pose.densefusion.estimator import Estimator
from warehouse_sim.estimators.segmenters.cluster import BoxClusters, detection_points
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.resources import model_names


class LidarChain(Pipeline):
    """Clusters of boxes, resampled, for a network that reads points alone.

    Args:
        network: The network's own chain.
        front: What finds detections before the clusters are taken; none where images bring their own.
        resampling: How a cluster becomes as many points as the network takes.
    """

    depth_source: DepthSource = "lidar"
    reads_rgb = False

    def __init__(
        self, network: Estimator, front: Sequence[FindDetections] = (), resampling: Resampling = "kmeans"
    ) -> None:
        self._network, self._resampling = network, resampling
        detect = (*front, BoxClusters())
        super().__init__(replace(network.stages, detect=detect, select=self._select), network.objects)

    @property
    def min_visible(self) -> LeastVisible:
        """Which of a dataset's targets it takes."""
        return self._network.min_visible

    def _select(self, image: RgbdImage) -> list[ObjectPoints]:
        return [self._resampled(image, crop) for crop in self._network.cut(image)]

    def _resampled(self, image: RgbdImage, crop: Crop) -> Crop:
        if crop.around is not None:
            # Points beside the mask, each with what is known of it, are drawn by the network's own rules.
            return crop
        seed = [self._network.config.seed, image.scene_id, image.image_id, crop.position]
        points = detection_points(image, image.detections[crop.position]).points
        chosen = resample(points, self._network.point_count, self._resampling, np.random.default_rng(seed))
        nothing = np.zeros(len(chosen))
        return replace(
            crop, points=chosen.astype(np.float32), border_px=nothing.astype(np.uint8), pixel=nothing.astype(np.int32)
        )


class LidarMethod(Composition):
    """What a name of ``ESTIMATORS`` stands for: a bundled network behind the LiDAR's front end.

    Args:
        network: Name of the network, which must read points alone.
        resampling: How clusters become a fixed number of points.
        detector: Name of what finds objects in depth made of sweeps; where it has no bundled weights, detections are
            to be given.
    """

    inputs = "LiDAR: boxes, clusters, cloud"

    def __init__(self, network: str, resampling: Resampling = "kmeans", detector: str = "detector-lidar") -> None:
        self.front_end, self.estimator, self._resampling = detector, network, resampling

    def configured(self, config: PredictConfig) -> PoseEstimator:
        """Return the estimator.

        Raises:
            InputError: The network reads an image, or uncertainty was fitted for it alone.
        """
        network = load_estimator(self.estimator, replace(config, uncertainty=False, reject=None))
        if config.reject is not None:
            raise InputError("no uncertainty was fitted for what LiDAR chains estimate; leave --reject out")
        if not isinstance(network, Estimator) or network.crop.side_px is not None:
            raise InputError(f"{self.estimator} reads an image; a LiDAR alone has none")
        chain = LidarChain(network, (), self._resampling)
        if self.front_end not in model_names():
            return chain
        return WithFrontEnd(chain, open_stages(self.front_end), config.objects)


DETECT_POINTCLOUD = LidarMethod("densefusion-pointcloud")
