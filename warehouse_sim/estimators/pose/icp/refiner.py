"""Point-to-plane refinement as the stage of a chain."""

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float

from warehouse_sim.estimators.pipeline import ObjectPoints, Proposals
from warehouse_sim.estimators.pose.fitting.hypotheses import own_of
from warehouse_sim.estimators.pose.icp.refine import IcpConfig, refine_poses
from warehouse_sim.estimators.pose.icp.surface import CadSurface, seeded_surface
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import Transforms


class IcpRefiner:
    """Fit poses to the points, whoever proposed them.

    Args:
        meshes: CAD surfaces (m, object frame) by obj_id.
        config: Settings.
        seed: Decides the samples of the surfaces.
    """

    def __init__(self, meshes: Mapping[int, TriangleMesh], config: IcpConfig, seed: int) -> None:
        self._meshes, self._config, self._seed = meshes, config, seed
        self._surfaces: dict[int, CadSurface] = {}

    def __call__(self, T_camera_object: Transforms, seen: Sequence[ObjectPoints], proposals: Proposals) -> Transforms:
        """Return the poses that fit the points, or the given ones where the fit gets no better."""
        surfaces = [self._surface(item.obj_id) for item in seen]
        # Crops may hold what is around an object, too.
        clouds = [item.masked_points for item in seen]
        clouds = [points[own_of(proposals, row, points)] for row, points in enumerate(clouds)]
        return refine_poses(T_camera_object, clouds, surfaces, self._config, _up(seen))

    def _surface(self, obj_id: int) -> CadSurface:
        if obj_id not in self._surfaces:
            self._surfaces[obj_id] = seeded_surface(self._meshes[obj_id], obj_id, self._seed)
        return self._surfaces[obj_id]


def _up(seen: Sequence[ObjectPoints]) -> Float[np.ndarray, "b 3"]:
    """Return the direction against gravity for each object, NaN if unknown."""
    down = [item.down for item in seen]
    return -np.array([np.full(3, np.nan) if item is None else item for item in down]).reshape(-1, 3)
