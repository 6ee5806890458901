"""Poses without a network: rectangles and swept poses as hypotheses, ICP for the best, and the depth image decides."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.estimators.api import PoseEstimator
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.matching import described, kind_bonus, may_be
from warehouse_sim.estimators.pose.fitting.hypotheses import LEAST_POINTS, look_alike, masked_points
from warehouse_sim.estimators.pose.fitting.joint import search_jointly
from warehouse_sim.estimators.pose.fitting.search import FitConfig, Found, Sought, fit_models, worth
from warehouse_sim.estimators.pose.fitting.verification import DepthView
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.schema import Agreement, PoseEstimate

_NOBODY_PROPOSES = np.empty((0, 4, 4))


class PoseFit(PoseEstimator):
    """Fits CAD models to the depth of each detection; nothing is trained.

    Args:
        config: Settings.
        seed: Decides which points are used.
    """

    reads_rgb = False
    learns_objects = True

    def __init__(self, config: FitConfig = FitConfig(), seed: int = 0) -> None:  # noqa: B008  frozen
        self.config, self._seed = config, seed
        self.onboard({})

    def onboard(self, objects: Mapping[int, ObjectInfo]) -> None:
        """Take over the CAD models."""
        self._infos = tuple(objects.values())
        known = {info.obj_id: info for info in self._infos}
        self._model = fit_models(lambda n: known[n].mesh(), lambda n: known[n].symmetry, self._seed)

    def estimate(self, image: RgbdImage) -> list[PoseEstimate]:
        """Return a pose for each detection that shows enough.

        Raises:
            InputError: A detection is of an object that it was not shown.
        """
        down = np.array([0.0, 1.0, 0.0]) if image.gravity is None else image.gravity
        pairs = [
            (info, Sought.of(self._model(info.obj_id), view, _NOBODY_PROPOSES, position, kind_bonus(item, info.name)))
            for position, item in enumerate(image.detections)
            if (view := self._view(image, position, item, down)) is not None
            for info in may_be(item, self._infos)
        ]
        if not pairs:
            return []
        best: dict[int, tuple[float, ObjectInfo, Found]] = {}
        for (info, item), found in zip(pairs, search_jointly([item for _, item in pairs], self.config), strict=True):
            if item.detection not in best or worth(item, found) > best[item.detection][0]:
                best[item.detection] = worth(item, found), info, found
        return [self._estimate(image, position, info, found) for position, (_, info, found) in best.items()]

    @staticmethod
    def _estimate(image: RgbdImage, position: int, info: ObjectInfo, found: Found) -> PoseEstimate:
        trust = float(np.clip(found.verification[0].score, 0.0, 1.0))
        estimate = described(image, position, info.obj_id, [info], trust, found.T_camera_object[0])
        return replace(estimate, agreement=_agreement(found, info.symmetry))

    def _view(
        self, image: RgbdImage, position: int, detection: Detection, down: Float[np.ndarray, " 3"]
    ) -> DepthView | None:
        rng = np.random.default_rng([self._seed, image.scene_id, image.image_id, detection.number_at(position)])
        mask = detection.pixels(*image.depth.shape)
        points = masked_points(image, mask, rng)
        return DepthView(image.camera, image.depth, mask, points, down) if len(points) >= LEAST_POINTS else None


def _agreement(found: Found, symmetry: SymmetryGroup) -> Agreement:
    """Return what the other hypotheses say of the first one."""
    T = found.T_camera_object
    others = np.flatnonzero(~look_alike(T, T[:1], symmetry, 0.03, 0.02)[:, 0])
    margin = found.verification[0].score - found.verification[others[0]].score if len(others) else 1.0
    spread = float(np.sqrt(((T[:, :3, 3] - T[:, :3, 3].mean(axis=0)) ** 2).sum(axis=1).mean()))
    return Agreement(spread=spread, margin=margin)


def rectangle_fit() -> PoseFit:
    """Return the baseline: the rectangle of what is seen, upright, no ICP."""
    return PoseFit(FitConfig(refine=False))
