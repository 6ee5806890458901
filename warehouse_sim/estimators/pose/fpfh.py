"""Features of points and fast global registration, as Open3D has them: a published method without training.

Fast point feature histograms (Rusu, Blodow and Beetz, ICRA 2009) pair points of the depth image with points of the CAD
surface; fast global registration (Zhou, Park and Koltun, ECCV 2016) finds the pose that most pairs agree on, and
point-to-plane ICP refines it. Sizes are those of Open3D's own example, by the voxel.
"""

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from jaxtyping import Float

from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.estimators.api import PoseEstimator
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.matching import described, may_be
from warehouse_sim.estimators.pose.fitting.hypotheses import LEAST_POINTS, masked_points
from warehouse_sim.geometry.pose import Transform, invert
from warehouse_sim.optional import require
from warehouse_sim.schema import PoseEstimate

_VOXEL = 0.02
"""Edge of a voxel over the diameter of the object."""
_NORMAL_RADIUS, _FEATURE_RADIUS, _PAIR_DISTANCE, _ICP_DISTANCE = 2.0, 5.0, 0.5, 1.0
"""In voxels."""
_NEIGHBOURS = 30, 100
"""Most of normals and of features."""
_MODEL_POINTS = 20_000


@dataclass(frozen=True, eq=False)
class _Cloud:
    """Points with normals, in voxels, and their features."""

    points: Any
    features: Any


class FpfhFgr(PoseEstimator):
    """Registers the CAD surface with the depth of each detection.

    Args:
        seed: Decides which points are used, and which pairs are tried.

    Raises:
        MissingPackageError: Open3D is not installed.
    """

    reads_rgb = False
    learns_objects = True

    def __init__(self, seed: int = 0) -> None:
        self._o3d = require("open3d", "open3d", "by fpfh-fgr")
        self._seed = seed
        self.onboard({})

    def onboard(self, objects: Mapping[int, ObjectInfo]) -> None:
        """Take over the CAD models."""
        self._infos = tuple(objects.values())
        known = {info.obj_id: info for info in self._infos}
        self._model = lru_cache(maxsize=None)(lambda obj_id: self._surface(known[obj_id]))

    def estimate(self, image: RgbdImage) -> list[PoseEstimate]:
        """Return a pose for each detection that shows enough, of the model that fits best.

        Raises:
            InputError: A detection is of an object that it was not shown.
        """
        started, found = time.perf_counter(), list[PoseEstimate]()
        for position, item in enumerate(image.detections):
            rng = np.random.default_rng([self._seed, image.scene_id, image.image_id, item.number_at(position)])
            points = masked_points(image, item.pixels(*image.depth.shape), rng)
            if len(points) < LEAST_POINTS:
                continue
            fits = [(info, *self._registered(points, info)) for info in may_be(item, self._infos)]
            fits = [fit for fit in fits if fit[1][2, 3] > 0.0]  # the rest lies behind the camera
            if fits:
                info, T_camera_object, fitness = max(fits, key=lambda fit: fit[2])
                found.append(described(image, position, info.obj_id, [info], fitness, T_camera_object))
        seconds = time.perf_counter() - started
        return [replace(item, time=seconds) for item in found]

    def _surface(self, info: ObjectInfo) -> _Cloud:
        o3d, mesh = self._o3d, info.mesh()
        o3d.utility.random.seed(self._seed)
        vector = o3d.utility.Vector3dVector
        surface = o3d.geometry.TriangleMesh(vector(mesh.vertices), o3d.utility.Vector3iVector(mesh.faces))
        surface.compute_triangle_normals()
        return self._described(surface.sample_points_uniformly(_MODEL_POINTS, True), _VOXEL * info.diameter)

    def _registered(self, points: Float[np.ndarray, "p 3"], info: ObjectInfo) -> tuple[Transform, float]:
        """Return the pose of a model, and the fraction (0-1) of the points that lie on it there."""
        o3d, voxel, model = self._o3d, _VOXEL * info.diameter, self._model(info.obj_id)
        seen = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points.astype(float)))
        seen = seen.voxel_down_sample(voxel)
        radius = o3d.geometry.KDTreeSearchParamHybrid(_NORMAL_RADIUS * voxel, _NEIGHBOURS[0])
        seen.estimate_normals(radius)
        seen.orient_normals_towards_camera_location(np.zeros(3))
        scene = self._described(seen, voxel)
        pipeline = o3d.pipelines.registration
        o3d.utility.random.seed(self._seed)
        coarse = pipeline.registration_fgr_based_on_feature_matching(
            scene.points,
            model.points,
            scene.features,
            model.features,
            pipeline.FastGlobalRegistrationOption(maximum_correspondence_distance=_PAIR_DISTANCE * voxel),
        )
        fine = pipeline.registration_icp(
            scene.points,
            model.points,
            _ICP_DISTANCE * voxel,
            coarse.transformation,
            pipeline.TransformationEstimationPointToPlane(),
        )
        return invert(fine.transformation), float(np.clip(fine.fitness, 0.0, 1.0))

    def _described(self, cloud: Any, voxel: float) -> _Cloud:
        thin = cloud.voxel_down_sample(voxel)
        around = self._o3d.geometry.KDTreeSearchParamHybrid(_FEATURE_RADIUS * voxel, _NEIGHBOURS[1])
        return _Cloud(thin, self._o3d.pipelines.registration.compute_fpfh_feature(thin, around))
