"""Poses without a network: rectangles and yaw starts as hypotheses, ICP for each, and the depth image decides."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.errors import InputError
from warehouse_sim.estimators.gravity import upright_frame
from warehouse_sim.estimators.pose.fitting.evidence import DepthView, Evidence, EvidenceConfig, judge
from warehouse_sim.estimators.pose.fitting.rectangle import upright_boxes
from warehouse_sim.estimators.pose.icp.refine import IcpConfig, refine_poses
from warehouse_sim.estimators.pose.icp.surface import CadSurface, build_surface
from warehouse_sim.estimators.rgbd_image import Detection, RgbdImage
from warehouse_sim.geometry.pose import Transform, Transforms, make_transform, rotation_z
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.schema import Agreement, PoseEstimate

_SURFACE_SAMPLES = 20_000
_POINTS = 1500
_LEAST_POINTS = 32


@dataclass(frozen=True)
@ranged
class FitConfig:
    """How poses are fitted without a network."""

    yaw_starts: Annotated[int, Range(0, 360)] = 8
    """Directions that are tried beside those of the rectangle, 0-360."""
    kept: Annotated[int, Range(1, 100)] = 3
    """Hypotheses that are refined to the end, 1-100."""
    doubt: Annotated[float, Range(0, 1)] = 0.02
    """By so much the evidence for another pose must exceed that for a network's, 0-1."""
    refine: bool = True
    """Whether ICP follows; without it the rectangle is the estimate."""
    gravity: bool = True
    """Whether the image's gravity is believed; without it the camera is taken for level."""
    coarse: IcpConfig = field(
        default_factory=lambda: IcpConfig(
            rounds=1, iterations=8, points=200, gate_start=0.3, gate_end=0.06, prior_shift=1.0, prior_turn=0.7,
            most_shift=0.8, most_turn=0.9,
        )
    )  # fmt: skip
    """Settings of the ICP that every hypothesis passes."""
    fine: IcpConfig = field(default_factory=lambda: IcpConfig(prior_shift=0.3, prior_turn=0.2))
    """Settings of the ICP of those that are kept."""
    coarse_evidence: EvidenceConfig = field(default_factory=lambda: EvidenceConfig(tolerance=0.06))
    """How the depth image is weighed where poses are some centimetres off."""
    evidence: EvidenceConfig = field(default_factory=EvidenceConfig)
    """How it is weighed in the end."""


@dataclass(frozen=True, eq=False)
class _Hypothesis:
    T_camera_object: Transform
    evidence: Evidence
    agreement: Agreement | None = None


class PoseFit:
    """Fits CAD models to the depth of each detection; nothing is trained.

    Args:
        config: Settings.
        seed: Decides which points are used.
    """

    objects = None
    reads_rgb = False

    def __init__(self, config: FitConfig = FitConfig(), seed: int = 0) -> None:
        self.config, self._seed = config, seed
        self._models: dict[int | str, ObjectInfo] = {}
        self._surfaces: dict[int, CadSurface] = {}

    def onboard(self, objects: Mapping[int, ObjectInfo]) -> None:
        """Take over the CAD models, by number and by name."""
        self._models = dict(objects) | {item.name: item for item in objects.values()}
        self._surfaces = {}

    def estimate(self, image: RgbdImage) -> list[PoseEstimate]:
        """Return a pose for each detection that shows enough.

        Raises:
            InputError: A detection is of an object that it was not shown.
        """
        known = image.gravity if self.config.gravity else None
        down = np.array([0.0, 1.0, 0.0]) if known is None else known
        found = (self._estimate(image, position, item, down) for position, item in enumerate(image.detections))
        return [item for item in found if item is not None]

    def _estimate(
        self, image: RgbdImage, position: int, detection: Detection, down: Float[np.ndarray, " 3"]
    ) -> PoseEstimate | None:
        number = position if detection.number is None else detection.number
        rng = np.random.default_rng([self._seed, image.scene_id, image.image_id, number])
        mask = detection.pixels(*image.depth.shape)
        points = masked_points(image, mask, rng)
        if len(points) < _LEAST_POINTS:
            return None
        tried = [(item, self._fit(image, mask, points, item, down)) for item in self._may_be(detection)]
        info, best = max(tried, key=lambda pair: pair[1].evidence.score)
        return PoseEstimate(
            image.scene_id,
            image.image_id,
            info.obj_id,
            detection.score * float(np.clip(best.evidence.score, 0.0, 1.0)),
            best.T_camera_object,
            name=info.name,
            class_name=info.class_name,
            detection=number,
            agreement=best.agreement,
        )

    def _fit(
        self,
        image: RgbdImage,
        mask: Bool[np.ndarray, "h w"],
        points: Float[np.ndarray, "p 3"],
        info: ObjectInfo,
        down: Float[np.ndarray, " 3"],
    ) -> _Hypothesis:
        config, surface = self.config, self._surface(info)
        points = within_reach(points, info.diameter)
        view = DepthView(image.camera, image.depth, mask, points[:400])
        T = distinct(hypotheses(points, info.size, down, config.yaw_starts if config.refine else 0), info.symmetry)
        if config.refine:
            T = refine_poses(T, [points] * len(T), [surface] * len(T), config.coarse, -down)
        judged = [_Hypothesis(pose, judge(pose, surface, view, config.coarse_evidence)) for pose in T]
        judged.sort(key=lambda item: -item.evidence.score)
        if not config.refine:
            return _with_agreement(judged, info.symmetry)
        T = np.stack([item.T_camera_object for item in judged[: config.kept]])
        T = refine_poses(T, [points] * len(T), [surface] * len(T), config.fine, -down)
        judged = [_Hypothesis(pose, judge(pose, surface, view, config.evidence)) for pose in T]
        judged.sort(key=lambda item: -item.evidence.score)
        return _with_agreement(judged, info.symmetry)

    def _surface(self, info: ObjectInfo) -> CadSurface:
        if info.obj_id not in self._surfaces:
            rng = np.random.default_rng([self._seed, info.obj_id])
            self._surfaces[info.obj_id] = build_surface(info.mesh(), _SURFACE_SAMPLES, rng)
        return self._surfaces[info.obj_id]

    def _may_be(self, detection: Detection) -> list[ObjectInfo]:
        if detection.model is None:
            return [item for key, item in self._models.items() if isinstance(key, int)]
        if detection.model not in self._models:
            raise InputError(f"the estimator was not shown the object {detection.model!r}")
        return [self._models[detection.model]]


def masked_points(
    image: RgbdImage, mask: Bool[np.ndarray, "h w"], rng: np.random.Generator
) -> Float[np.ndarray, "p 3"]:
    """Return points of a mask (camera frame, m), 1,500 at most, in random order."""
    v, u = np.nonzero(mask & (image.depth > 0))
    chosen = rng.permutation(len(u))[:_POINTS]
    u, v = u[chosen], v[chosen]
    return image.camera.rays_at(u, v) * image.depth[v, u][:, None].astype(float)


def hypotheses(
    points: Float[np.ndarray, "p 3"], size: Float[np.ndarray, " 3"], down: Float[np.ndarray, " 3"], yaw_starts: int
) -> Transforms:
    """Return upright poses ``T_camera_object`` that a box about these points may have, (h 4 4).

    Args:
        points: Of the object's surface (camera frame, m).
        size: Edge lengths of its box (m).
        down: Unit vector of gravity (camera frame).
        yaw_starts: Directions to try beside those of the rectangle.
    """
    R_camera_upright = upright_frame(down)
    T_camera_upright = make_transform(R_camera_upright, np.zeros(3))
    upright = points @ R_camera_upright
    found = [upright_boxes(upright, size)]
    if yaw_starts:
        middle = np.median(upright, axis=0)
        # The points are those of the near sides: the centre is about a quarter of the width behind them.
        middle[:2] += middle[:2] / np.linalg.norm(middle[:2]) * min(size[:2]) / 4.0
        yaws = np.arange(yaw_starts) * (2.0 * np.pi / yaw_starts)
        found.append(np.stack([make_transform(rotation_z(yaw), middle) for yaw in yaws]))
    return T_camera_upright @ np.concatenate(found)


def distinct(
    T_camera_object: Transforms, symmetry: SymmetryGroup, turn: float = 0.1, shift: float = 0.05
) -> Transforms:
    """Return the poses without those that look like an earlier one within ``turn`` (rad) and ``shift`` (m)."""
    kept: list[Transform] = []
    for pose in T_camera_object:
        look = pose @ symmetry.transforms
        if not any(_is_near(other, look, turn, shift) for other in kept):
            kept.append(pose)
    return np.stack(kept)


def _with_agreement(judged: list[_Hypothesis], symmetry: SymmetryGroup) -> _Hypothesis:
    """Return the first of some hypotheses, which are sorted by evidence, with what the others say of it."""
    first, look = judged[0], judged[0].T_camera_object @ symmetry.transforms
    others = [item for item in judged[1:] if not _is_near(item.T_camera_object, look, 0.03, 0.02)]
    margin = first.evidence.score - others[0].evidence.score if others else 1.0
    places = np.stack([item.T_camera_object[:3, 3] for item in judged])
    spread = float(np.sqrt(((places - places.mean(axis=0)) ** 2).sum(axis=1).mean()))
    return replace(first, agreement=Agreement(spread=spread, margin=margin))


def _is_near(pose: Transform, others: Transforms, turn: float, shift: float) -> bool:
    away = np.linalg.norm(others[:, :3, 3] - pose[:3, 3], axis=1)
    cosine = (np.einsum("gij,ij->g", others[:, :3, :3], pose[:3, :3]) - 1.0) / 2.0
    return bool(((away <= shift) & (cosine >= np.cos(turn))).any())


def within_reach(points: Float[np.ndarray, "p 3"], diameter: float) -> Float[np.ndarray, "p 3"]:
    """Leave out points that cannot be of one object with the middle ones."""
    middle = np.median(points, axis=0)
    near = np.linalg.norm(points - middle, axis=1) <= diameter
    return points[near] if near.sum() >= _LEAST_POINTS else points


def rectangle_fit() -> PoseFit:
    """Return the trivial method: the rectangle of what is seen, upright, no ICP."""
    return PoseFit(FitConfig(refine=False))


def icp_multistart() -> PoseFit:
    """Return rectangles and yaw starts, each refined by ICP, the best by the depth image."""
    return PoseFit()
