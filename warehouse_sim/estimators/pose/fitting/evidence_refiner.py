"""Hypotheses, then evidence: poses of a network and poses that the points suggest, fitted, and judged by the image."""

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float

from warehouse_sim.estimators.chain import ObjectPoints, Proposals
from warehouse_sim.estimators.pose.choose import Candidates
from warehouse_sim.estimators.pose.fitting.evidence import DepthView, judge
from warehouse_sim.estimators.pose.fitting.fit import FitConfig, distinct, hypotheses, within_reach
from warehouse_sim.estimators.pose.icp.refine import refine_poses
from warehouse_sim.estimators.pose.icp.surface import CadSurface, build_surface
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import Transform, Transforms, make_transform, matrix_from_quat_wxyz, rotation_z
from warehouse_sim.geometry.symmetry import SymmetryGroup

_SURFACE_SAMPLES = 20_000
_PROPOSALS = 4
"""Proposals of the network that are tried beside the chosen pose, the most confident ones that differ."""
_QUARTERS = tuple(make_transform(rotation_z(quarter * np.pi / 2.0), np.zeros(3)) for quarter in (1, 2, 3))
"""Poses that look alike from afar."""


class EvidenceRefiner:
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
        self._surfaces: dict[int, CadSurface] = {}

    def __call__(self, T_camera_object: Transforms, seen: Sequence[ObjectPoints], proposals: Proposals) -> Transforms:
        """Return the poses (b 4 4) that the images speak for; those without a view stay as they are."""
        found = {i: getattr(item, "view", None) for i, item in enumerate(seen)}
        views: dict[int, DepthView] = {i: view for i, view in found.items() if view is not None and len(view.points)}
        T = T_camera_object.copy()
        if not views:
            return T
        numbers = {i: seen[i].obj_id for i in views}
        tried = {i: self._tried(T[i], view, numbers[i], proposals.candidates, i) for i, view in views.items()}
        coarse = self._fitted(tried, views, numbers, fine=False)
        kept = {i: self._best(poses, views[i], numbers[i], coarse=True) for i, poses in coarse.items()}
        for i, poses in self._fitted(kept, views, numbers, fine=True).items():
            T[i] = self._best(poses, views[i], numbers[i], coarse=False)[0]
        return T

    def _tried(
        self, T_network: Transform, view: DepthView, obj_id: int, candidates: Candidates, row: int
    ) -> Transforms:
        """Return the poses to try, that of the network first."""
        order = np.argsort(-candidates.confidence[row])[:: max(candidates.confidence.shape[1] // 32, 1)]
        rotation = matrix_from_quat_wxyz(candidates.quat_wxyz[row, order])
        proposed = make_transform(rotation, candidates.translation[row, order])
        symmetry = self._symmetries[obj_id]
        proposed = distinct(np.concatenate([T_network[None], proposed]), symmetry)[: 1 + _PROPOSALS]
        surface = self._surface(obj_id)
        points = within_reach(view.points, _extent(surface))
        down = np.array([0.0, 1.0, 0.0]) if view.down is None else view.down
        upright = hypotheses(points, np.ptp(surface.points, axis=0), down, self._config.yaw_starts)
        return distinct(np.concatenate([proposed, T_network @ np.stack(_QUARTERS), upright]), symmetry)

    def _fitted(
        self, poses: Mapping[int, Transforms], views: Mapping[int, DepthView], numbers: Mapping[int, int], fine: bool
    ) -> dict[int, Transforms]:
        """Return the poses of all objects after ICP, in one batch."""
        rows = [i for i, found in poses.items() for _ in found]
        surfaces = [self._surface(numbers[i]) for i in rows]
        clouds = {i: within_reach(views[i].points, _extent(self._surface(numbers[i]))) for i in poses}
        downs = [views[i].down for i in rows]
        up = np.stack([np.full(3, np.nan) if down is None else -down for down in downs])
        config = self._config.fine if fine else self._config.coarse
        found = refine_poses(np.concatenate(list(poses.values())), [clouds[i] for i in rows], surfaces, config, up)
        ends = np.cumsum([len(item) for item in poses.values()])
        return dict(zip(poses, np.split(found, ends[:-1]), strict=True))

    def _best(self, poses: Transforms, view: DepthView, obj_id: int, coarse: bool) -> Transforms:
        """Return the poses in order of the evidence, those of the last round that are kept; ties go to the first."""
        config = self._config.coarse_evidence if coarse else self._config.evidence
        surface = self._surface(obj_id)
        scores: Float[np.ndarray, " h"] = np.array([judge(pose, surface, view, config).score for pose in poses])
        scores[0] += self._config.doubt
        order = np.argsort(-scores, kind="stable")
        if not coarse:
            return poses[order[:1]]
        kept = list(order[: self._config.kept])
        # The network's own stays among those that are judged at last.
        return poses[[0, *(i for i in kept if i != 0)]]

    def _surface(self, obj_id: int) -> CadSurface:
        if obj_id not in self._surfaces:
            rng = np.random.default_rng([self._seed, obj_id])
            self._surfaces[obj_id] = build_surface(self._meshes[obj_id], _SURFACE_SAMPLES, rng)
        return self._surfaces[obj_id]


def _extent(surface: CadSurface) -> float:
    """Return the diagonal of a surface's box (m)."""
    return float(np.linalg.norm(np.ptp(surface.points, axis=0)))
