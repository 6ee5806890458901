"""Settings of the fit of pallet faces."""

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from jaxtyping import Bool, Float
from scipy.special import erf

from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.errors import InputError
from warehouse_sim.estimators.api import PoseEstimator
from warehouse_sim.estimators.gravity import Direction, down_from_floor, upright_frame
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.pose.faces.answer import describe, without_walls
from warehouse_sim.estimators.pose.faces.plane_view import PlaneView, view_plane
from warehouse_sim.estimators.pose.faces.planes import SolidPlane, face_planes, fit_plane
from warehouse_sim.estimators.pose.faces.shape import ANY_PALLET, CatalogFace, FacePrior, catalog_faces
from warehouse_sim.estimators.pose.faces.template import FaceLikelihood, FrontFit, fit_face
from warehouse_sim.estimators.pose.fitting.hypotheses import masked_points
from warehouse_sim.geometry.pose import Transform, invert, make_transform, rotation_x, transform_points
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.schema import PalletFace, PoseEstimate


@dataclass(frozen=True)
@ranged
class FaceConfig:
    """How a face is fitted."""

    planes: Annotated[int, Range(1, 20)] = 3
    """Upright planes that are looked at, 1-20."""
    rounds: Annotated[int, Range(1, 10)] = 2
    """How often plane and face are fitted in turn, 1-10."""
    gravity: bool = True
    """Whether the image's gravity is believed; without it the floor in sight is, or the camera is taken for level."""
    gravity_deg: Annotated[float, Range(0.01, 30, "deg")] = 0.5
    """Standard deviation of gravity, and of a pallet's own tilt, 0.01-30."""
    floor_deg: Annotated[float, Range(0.01, 30, "deg")] = 0.7
    """Least standard deviation of gravity where the floor in sight gives it, 0.01-30."""
    level_deg: Annotated[float, Range(0.01, 45, "deg")] = 4.0
    """Standard deviation of gravity where the camera is taken for level, 0.01-45."""
    catalog_spread: Annotated[float, Range(0.0005, 0.1, "m")] = 0.004
    """How far pallets are from a CAD that is named (m), 0.0005-0.1."""
    range_bias: Annotated[float, Range(0, 0.2, "m")] = 0.01
    """Standard deviation of what all readings are off together (m), 0-0.2."""
    min_openings: Annotated[float, Range(0, 1000)] = 6.0
    """Log likelihood that the pockets must add; with less there is no answer, 0-1,000."""


_LOOKS = 3
"""The floor is looked for so often, each time on other readings; where it is no plane, as a mirror is, they differ."""


@dataclass(frozen=True, eq=False)
class Leveling:
    """Gravity in the camera frame."""

    down: Direction
    sigma: float
    """Standard deviation about each horizontal axis (rad)."""


def find_down(image: RgbdImage, config: FaceConfig, rng: np.random.Generator) -> Leveling:
    """Return gravity as the image brings it, else as the floor has it, else that of a level camera."""
    if config.gravity and image.gravity is not None:
        return Leveling(np.asarray(image.gravity, dtype=float), np.deg2rad(config.gravity_deg))
    seen = [down_from_floor(image.camera, image.depth, rng) for _ in range(_LOOKS)]
    found = [down for down in seen if down is not None]
    if len(found) < _LOOKS:
        return Leveling(np.array([0.0, 1.0, 0.0]), np.deg2rad(config.level_deg))
    mean = np.mean(found, axis=0)
    mean /= np.linalg.norm(mean)
    spread = float(np.sqrt(np.mean([np.sum((down - mean) ** 2) for down in found])))
    sigma = float(np.hypot(np.deg2rad(config.floor_deg), 1.5 * spread))
    return Leveling(mean, min(sigma, np.deg2rad(config.level_deg)))


_LEAST_POINTS = 60
_AROUND = np.array([0.20, 0.10])
"""How far (m) beyond what is seen on a plane the face may go, along y and z."""
_MOST_CELLS = 400
_ROLLS, _FINER_ROLLS = (-1.6, -0.8, 0.8, 1.6), (-0.4, -0.2, 0.2, 0.4)
"""Turns about the plane's normal that are tried where gravity is unsure, in its standard deviations; then those about
the best of them."""
_SURE_ROLL = np.deg2rad(1.0)
_TINE = (0.100, 0.040)
"""Width and thickness (m) of a common tine, which the score asks about."""
_REACH = 1.10


@dataclass(frozen=True, eq=False)
class _Found:
    """A face on a plane."""

    view: PlaneView
    fit: FrontFit
    plane: SolidPlane
    roll: float
    """Error of the turn in the plane (rad)."""
    catalog: CatalogFace | None
    info: ObjectInfo | None


class FaceEstimator(PoseEstimator):
    """Fits a parametric face to the depth of each detection.

    Args:
        config: Settings.
        seed: Decides which points are used.
    """

    reads_rgb = False
    learns_objects = True

    def __init__(self, config: FaceConfig = FaceConfig(), seed: int = 0) -> None:
        self.config, self._seed = config, seed
        self._models: dict[int | str, ObjectInfo] = {}

    def onboard(self, objects: Mapping[int, ObjectInfo]) -> None:
        """Take over the sizes and pockets of known pallets, by number and by name."""
        self._models = dict(objects) | {item.name: item for item in objects.values()}

    def estimate(self, image: RgbdImage) -> list[PoseEstimate]:
        """Return a face for each detection where the depth image decides; of the others it says nothing.

        Raises:
            InputError: A detection is of an object that it was not shown.
        """
        rng = np.random.default_rng([self._seed, image.scene_id, image.image_id])
        started = time.perf_counter()
        level = find_down(image, self.config, rng)
        found = [self._estimate(image, index, item, level) for index, item in enumerate(image.detections)]
        seconds = time.perf_counter() - started
        return [replace(item, time=seconds) for item in found if item is not None]

    def _estimate(self, image: RgbdImage, position: int, detection: Detection, level: Leveling) -> PoseEstimate | None:
        number = position if detection.number is None else detection.number
        rng = np.random.default_rng([self._seed, image.scene_id, image.image_id, number])
        mask = detection.pixels(*image.depth.shape)
        points = masked_points(image, mask, rng)
        if len(points) < _LEAST_POINTS:
            return None
        best: _Found | None = None
        for info, catalog in self._priors(detection):
            found = self._fit(image, mask, detection.mask is not None, points, level, catalog, info, rng)
            if found and (best is None or found.fit.score > best.fit.score):
                best = found
        if best is None or best.fit.openings < self.config.min_openings or best.fit.score <= 0.0:
            return None
        face = describe(best.view.T_camera_plane, best.fit, best.plane, best.roll, self.config.range_bias)
        score = detection.score * probability_of_entry(face)
        if best.info is None or best.catalog is None:
            pose, obj_id, name, class_name = face.T_camera_dock, 0, "", "pallet"
        else:
            pose = face.T_camera_dock @ invert(best.catalog.T_object_dock)
            obj_id, name, class_name = best.info.obj_id, best.info.name, best.info.class_name
        return PoseEstimate(
            image.scene_id, image.image_id, obj_id, score, pose,
            name=name, class_name=class_name, detection=number, face=face,
        )  # fmt: skip

    def _priors(self, detection: Detection) -> list[tuple[ObjectInfo | None, CatalogFace | None]]:
        if detection.model is None:
            return [(None, None)]
        if detection.model not in self._models:
            raise InputError(f"the estimator was not shown the object {detection.model!r}")
        info = self._models[detection.model]
        sides = catalog_faces(info.size, info.pockets, self.config.catalog_spread)
        # Opposite sides are alike: the one is as good as the other.
        unlike = {tuple(np.round(side.prior.usual[2:], 3)): side for side in sides}
        return [(info, side) for side in unlike.values()]

    def _fit(
        self,
        image: RgbdImage,
        mask: Bool[np.ndarray, "h w"],
        masked: bool,
        points: Float[np.ndarray, "p 3"],
        level: Leveling,
        catalog: CatalogFace | None,
        info: ObjectInfo | None,
        rng: np.random.Generator,
    ) -> _Found | None:
        config, prior = self.config, catalog.prior if catalog else ANY_PALLET
        R = upright_frame(level.down)
        T_camera_upright = make_transform(R, np.zeros(3))
        tolerance = 0.015 + 0.008 * float(np.median(points[:, 2]))
        best: tuple[float, PlaneView, FrontFit, float] | None = None
        for T in face_planes(points @ R, tolerance, config.planes, rng):
            found = self._look(image, mask, masked, points, T_camera_upright @ T, tolerance, prior, rng)
            if found and (best is None or found[1].score > best[0]):
                best = found[1].score, *found
        if best is None:
            return None
        _, view, fit, sigma = best
        roll = level.sigma
        if level.sigma > _SURE_ROLL:
            view, fit, roll = self._roll(image, mask, masked, view, fit, sigma, level, prior, rng)
        leaned, plane = 0.0, None
        for _ in range(config.rounds):
            before = view.T_camera_plane
            plane = fit_plane(view, fit.shape, sigma, (-leaned, level.sigma))
            leaned += float(np.arcsin(np.clip(-(before[:3, 2] @ plane.T_camera_plane[:3, 0]), -1, 1)))
            sigma = float(np.clip(plane.sigma, 0.003, 0.06))
            low, high = view.low, view.low + view.cell * np.array(view.behind.shape[::-1])
            view = view_plane(image, mask, plane.T_camera_plane, low, high, view.cell)
            likelihood = FaceLikelihood(view, sigma, max(plane.dependent, 4.0), masked)
            again = fit_face(likelihood, prior, _about(fit), rng)
            if again is None:
                return None
            fit = again
        assert plane is not None
        fit = without_walls(fit, view, sigma, catalog is not None)
        return _Found(view, fit, plane, roll, catalog, info)

    def _look(
        self,
        image: RgbdImage,
        mask: Bool[np.ndarray, "h w"],
        masked: bool,
        points: Float[np.ndarray, "p 3"],
        T_camera_plane: Transform,
        tolerance: float,
        prior: FacePrior,
        rng: np.random.Generator,
    ) -> tuple[PlaneView, FrontFit, float] | None:
        """Return what a plane shows, the face that fits best, and the error of readings."""
        inside = transform_points(invert(T_camera_plane), points)
        on = np.abs(inside[:, 0]) <= tolerance
        if on.sum() < _LEAST_POINTS // 2:
            return None
        seen = np.quantile(inside[on, 1:], 0.01, axis=0), np.quantile(inside[on, 1:], 0.99, axis=0)
        low, high = seen[0] - _AROUND, seen[1] + _AROUND
        pixel = float(T_camera_plane[2, 3]) / image.camera.fx
        cell = max(0.003, 0.8 * pixel, float((high - low).max()) / _MOST_CELLS)
        view = view_plane(image, mask, T_camera_plane, low, high, cell)
        sigma = float(np.clip(1.4826 * np.median(np.abs(inside[on, 0])), 0.004, 0.05))
        fit = fit_face(FaceLikelihood(view, sigma, 9.0, masked), prior, seen, rng, starts=1)
        return None if fit is None else (view, fit, sigma)

    def _roll(
        self,
        image: RgbdImage,
        mask: Bool[np.ndarray, "h w"],
        masked: bool,
        view: PlaneView,
        fit: FrontFit,
        sigma: float,
        level: Leveling,
        prior: FacePrior,
        rng: np.random.Generator,
    ) -> tuple[PlaneView, FrontFit, float]:
        """Return view and face after the turn in the plane that makes edges straightest, and how sure it is (rad)."""
        low, high = view.low, view.low + view.cell * np.array(view.behind.shape[::-1])
        tried = {0.0: (fit.score, view, fit)}
        for steps in (_ROLLS, _FINER_ROLLS):
            middle = max(tried, key=lambda turn: tried[turn][0])
            for turn in (middle + step * level.sigma for step in steps):
                T = view.T_camera_plane @ make_transform(rotation_x(turn), np.zeros(3))
                turned = view_plane(image, mask, T, low, high, view.cell)
                found = fit_face(FaceLikelihood(turned, sigma, 9.0, masked), prior, _about(fit), rng, starts=1)
                if found:
                    tried[turn] = found.score - 0.5 * (turn / level.sigma) ** 2, turned, found
        turns = np.array(list(tried))
        worth = np.array([item[0] for item in tried.values()])
        best = turns[worth.argmax()]
        weight = np.exp(worth - worth.max())
        spread = weight @ (turns - best) ** 2 / weight.sum() + (_FINER_ROLLS[-1] / 2.0 * level.sigma) ** 2
        return tried[best][1], tried[best][2], float(np.sqrt(spread))


def probability_of_entry(face: PalletFace) -> float:
    """Return how likely both tines stay clear of the walls, were the stated errors normal and independent."""
    deviation = face.covariance
    side = np.sqrt(deviation[4, 4] + _REACH**2 * deviation[2, 2])
    up = np.sqrt(deviation[5, 5] + _REACH**2 * deviation[1, 1])
    clearance = (face.pocket_sizes.min(axis=0) - _TINE) / 2.0
    chances = [
        erf(max(space, 0.0) / (np.sqrt(2.0) * sigma)) for space, sigma in zip(clearance, (side, up), strict=True)
    ]
    return float(np.prod(chances))


def _about(fit: FrontFit) -> tuple[Float[np.ndarray, " 2"], Float[np.ndarray, " 2"]]:
    """Return the rectangle of a face."""
    middle, foot, width, height = fit.shape[:4]
    return np.array([middle - width / 2.0, foot]), np.array([middle + width / 2.0, foot + height])


def front_fit() -> FaceEstimator:
    """Return the estimator as it is by default."""
    return FaceEstimator()
