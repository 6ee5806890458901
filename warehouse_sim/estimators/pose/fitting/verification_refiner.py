"""Multi-hypothesis ICP with depth verification: poses of a network and of the points, judged by the image."""

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float

from warehouse_sim.estimators.pipeline import ObjectPoints, Proposals
from warehouse_sim.estimators.pose.fitting.hypotheses import distinct, own_of
from warehouse_sim.estimators.pose.fitting.joint import search_jointly
from warehouse_sim.estimators.pose.fitting.search import VERIFICATION, FitConfig, FitModel, Sought
from warehouse_sim.estimators.pose.fitting.verification import DepthView, judge
from warehouse_sim.estimators.pose.icp.surface import seeded_surface
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import SymmetryGroup, Transform, Transforms, make_transform, matrix_from_quat_wxyz

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
        self._meshes, self._symmetries, self._config, self._seed = meshes, symmetries, config, seed
        self._models: dict[int, FitModel] = {}

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
            whole = Sought.of(self._model(seen[i].obj_id), view, proposed, detection)
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

    def _model(self, obj_id: int) -> FitModel:
        if obj_id not in self._models:
            surface = seeded_surface(self._meshes[obj_id], obj_id, self._seed)
            self._models[obj_id] = FitModel(surface, self._symmetries[obj_id])
        return self._models[obj_id]


def _views(seen: Sequence[ObjectPoints]) -> dict[int, DepthView]:
    """Return the images of those that bring one, by their positions."""
    return {i: item.view for i, item in enumerate(seen) if item.view is not None and len(item.view.points)}
