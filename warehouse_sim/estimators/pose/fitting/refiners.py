"""ICP, and its multi-hypothesis form with depth verification, as stages of a chain."""

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float

from warehouse_sim.estimators.pipeline import ObjectPoints, Proposals
from warehouse_sim.estimators.pose.fitting.hypotheses import distinct, own_of
from warehouse_sim.estimators.pose.fitting.joint import search_jointly
from warehouse_sim.estimators.pose.fitting.search import VERIFICATION, FitConfig, Sought, fit_models
from warehouse_sim.estimators.pose.fitting.verification import DepthView, judge
from warehouse_sim.estimators.pose.icp.refine import IcpConfig, refine_poses
from warehouse_sim.estimators.pose.icp.surface import seeded_surfaces
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import Transform, Transforms, make_transform, matrix_from_quat_wxyz
from warehouse_sim.geometry.symmetry import SymmetryGroup


class IcpRefiner:
    """Fit poses to the points, whoever proposed them.

    Args:
        meshes: CAD surfaces (m, object frame) by obj_id.
        config: Settings.
        seed: Decides the samples of the surfaces.
    """

    def __init__(self, meshes: Mapping[int, TriangleMesh], config: IcpConfig, seed: int) -> None:
        self._config, self._surface = config, seeded_surfaces(meshes.__getitem__, seed)

    def __call__(self, T_camera_object: Transforms, seen: Sequence[ObjectPoints], proposals: Proposals) -> Transforms:
        """Return the poses that fit the points, or the given ones where the fit gets no better."""
        surfaces = [self._surface(item.obj_id) for item in seen]
        # Crops may hold what is around an object, too.
        clouds = [item.masked_points for item in seen]
        clouds = [points[own_of(proposals, row, points)] for row, points in enumerate(clouds)]
        return refine_poses(T_camera_object, clouds, surfaces, self._config, _up(seen))


def _up(seen: Sequence[ObjectPoints]) -> Float[np.ndarray, "b 3"]:
    """Return the direction against gravity for each object, NaN if unknown."""
    down = [item.down for item in seen]
    return -np.array([np.full(3, np.nan) if item is None else item for item in down]).reshape(-1, 3)


_PROPOSALS = 4
"""Proposals of the network that are tried beside the chosen pose, the most confident ones that differ."""


class VerificationRefiner:
    """Refine several poses of each object, and take the one for which the depth image speaks.

    Where the image does not decide, the network's pose stays.

    Args:
        meshes: CAD surfaces (m, object frame) by obj_id.
        symmetries: Of the objects, by obj_id.
        config: Settings.
        seed: Decides the samples of the surfaces.
    """

    def __init__(
        self,
        meshes: Mapping[int, TriangleMesh],
        symmetries: Mapping[int, SymmetryGroup],
        config: FitConfig,
        seed: int,
    ) -> None:
        self._config = config
        self._model = fit_models(meshes.__getitem__, symmetries.__getitem__, seed)

    def __call__(self, T_camera_object: Transforms, seen: Sequence[ObjectPoints], proposals: Proposals) -> Transforms:
        """Return the poses (b 4 4) that the images speak for; those without a view stay as they are."""
        views = _views(seen)
        T = T_camera_object.copy()
        if not views:
            return T
        detections: dict[tuple[int, int], int] = {}
        sought = []
        for i, view in views.items():
            # The objects that one detection may be stand beside each other, with one number.
            detection = detections.setdefault((id(view.depth), seen[i].position), len(detections))
            proposed = self._proposed(T[i], seen[i], proposals, i)
            whole = Sought.of(self._model(seen[i].obj_id), view, proposed, detection, seen[i].bonus)
            sought.append(whole.looked_for_among(own_of(proposals, i, view.points)))
        for i, found in zip(views, search_jointly(sought, self._config), strict=True):
            T[i] = found.T_camera_object[0]
        return T

    def prefer(
        self, T_camera_object: Transforms, seen: Sequence[ObjectPoints], proposals: Proposals
    ) -> Float[np.ndarray, " b"]:
        """Return the verification for each object in its pose; without a view its proposals' largest confidence."""
        worth: Float[np.ndarray, " b"] = proposals.candidates.confidence.max(axis=1)
        for i, view in _views(seen).items():
            surface = self._model(seen[i].obj_id).surface
            worth[i] = judge(T_camera_object[i], surface, view, VERIFICATION).score
        return worth

    def _proposed(self, T_network: Transform, item: ObjectPoints, proposals: Proposals, row: int) -> Transforms:
        """Return the pose that a network gives, and others that it proposes, the most confident ones first."""
        candidates = proposals.candidates
        order = np.argsort(-candidates.confidence[row])[:: max(candidates.confidence.shape[1] // 32, 1)]
        rotation = matrix_from_quat_wxyz(candidates.quat_wxyz[row, order])
        proposed = make_transform(rotation, candidates.translation[row, order])
        model = self._model(item.obj_id)
        return distinct(np.concatenate([T_network[None], proposed]), model.symmetry)[: 1 + _PROPOSALS]


def _views(seen: Sequence[ObjectPoints]) -> dict[int, DepthView]:
    """Return the images of those that bring one, by their positions."""
    return {i: item.view for i, item in enumerate(seen) if item.view is not None and len(item.view.points)}
