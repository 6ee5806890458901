"""Look at the estimates of whatever estimator, in the images that it was given."""

from collections.abc import Callable, Sequence

import numpy as np
from jaxtyping import Bool

from warehouse_sim.estimators.pose.icp.surface import CadSurface, build_surface
from warehouse_sim.estimators.pose.uncertainty.features import Look, look
from warehouse_sim.estimators.rgbd_image import Detection, RgbdImage
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.schema import PoseEstimate

_SURFACE_SAMPLES = 8000


class Watcher:
    """Looks at estimates.

    Args:
        mesh_of: Returns the CAD surface (m, object frame) of an obj_id, or None of an object without one.
        seed: Decides which readings and samples are used.
    """

    def __init__(self, mesh_of: Callable[[int], TriangleMesh | None], seed: int = 0) -> None:
        self._mesh_of, self._seed = mesh_of, seed
        self._surfaces: dict[int, CadSurface | None] = {}

    def __call__(self, images: Sequence[RgbdImage], estimates: Sequence[PoseEstimate]) -> list[Look | None]:
        """Return what is seen of each estimate; None where there is no CAD surface or no reading.

        Args:
            images: All in which something was estimated.
            estimates: What was estimated in them.
        """
        by_place = {(image.scene_id, image.image_id): image for image in images}
        return [self._look(by_place[item.scene_id, item.image_id], item) for item in estimates]

    def _look(self, image: RgbdImage, estimate: PoseEstimate) -> Look | None:
        surface, mask = self._surface(estimate.obj_id), _mask_of(image, estimate.detection)
        if surface is None or mask is None:
            return None
        numbers = self._seed, image.scene_id, image.image_id, max(estimate.detection, 0)
        rng = np.random.default_rng(numbers)
        return look(estimate.T_camera_object, surface, image, mask, estimate.score, estimate.agreement, rng)

    def _surface(self, obj_id: int) -> CadSurface | None:
        if obj_id not in self._surfaces:
            mesh = self._mesh_of(obj_id)
            rng = np.random.default_rng([self._seed, obj_id])
            self._surfaces[obj_id] = None if mesh is None else build_surface(mesh, _SURFACE_SAMPLES, rng)
        return self._surfaces[obj_id]


def _mask_of(image: RgbdImage, number: int) -> Bool[np.ndarray, "h w"] | None:
    """Return the pixels of the detection that estimates call ``number``; None where there is none."""
    for position, item in enumerate(image.detections):
        if (position if item.number is None else item.number) == number:
            return _pixels(item, image)
    return None


def _pixels(detection: Detection, image: RgbdImage) -> Bool[np.ndarray, "h w"]:
    return detection.pixels(*image.depth.shape)
