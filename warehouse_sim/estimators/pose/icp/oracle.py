"""The ceiling that a depth sensor sets: ICP that starts at the labelled pose, on the pixels of its mask."""

from collections.abc import Iterable, Mapping

import numpy as np

from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.reader import ImageRecord, TargetRecord
from warehouse_sim.errors import InputError
from warehouse_sim.estimators.api import PoseEstimator
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.matching import described
from warehouse_sim.estimators.pose.fitting.hypotheses import LEAST_POINTS, masked_points
from warehouse_sim.estimators.pose.icp.refine import IcpConfig, refine_poses
from warehouse_sim.estimators.pose.icp.surface import seeded_surfaces
from warehouse_sim.schema import PoseEstimate


class OracleIcp(PoseEstimator):
    """Refines the labels' own poses: what remains of error is the sensor's, and ICP's.

    No method: it reads the labels that it is scored by. Whoever divides the score of a method by its score sees what
    the method lacks, and not what the sensor does.

    Args:
        seed: Decides which points are used.
    """

    reads_rgb = False
    learns_objects = True

    def __init__(self, seed: int = 0) -> None:
        self._seed = seed
        self.onboard({})
        self._labels: dict[tuple[int, int], dict[int, TargetRecord]] = {}

    def onboard(self, objects: Mapping[int, ObjectInfo]) -> None:
        """Take over the CAD models."""
        self._infos = objects
        self._surface = seeded_surfaces(lambda obj_id: objects[obj_id].mesh(), self._seed)

    def show(self, images: Iterable[ImageRecord]) -> None:
        """Take over the labels of images."""
        self._labels = {
            (image.scene_id, image.image_id): {target.gt_index: target for target in image.targets if target.has_pose}
            for image in images
        }

    def estimate(self, image: RgbdImage) -> list[PoseEstimate]:
        """Return the fitted pose of each detection whose mask has depth.

        Raises:
            InputError: A detection is none of the labels.
        """
        labels = self._labels.get((image.scene_id, image.image_id), {})
        up = None if image.gravity is None else -np.asarray(image.gravity, dtype=float)
        found = list[PoseEstimate]()
        for position, item in enumerate(image.detections):
            number = item.number_at(position)
            if number not in labels:
                raise InputError(f"oracle-icp starts at the poses of the labels, and none is numbered {number}")
            target = labels[number]
            rng = np.random.default_rng([self._seed, image.scene_id, image.image_id, number])
            points = masked_points(image, item.pixels(*image.depth.shape), rng)
            if len(points) < LEAST_POINTS:
                continue
            info = target.info(self._infos)
            start = target.T_camera_object[None]
            T = refine_poses(
                start, [points], [self._surface(info.obj_id)], IcpConfig(), None if up is None else up[None]
            )
            found.append(described(image, position, info.obj_id, [info], 1.0, T[0]))
        return found
