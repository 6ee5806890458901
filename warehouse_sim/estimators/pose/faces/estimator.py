"""The fit of pallet faces to the depth of each detection."""

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float
from scipy.special import erf

from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.errors import InputError
from warehouse_sim.estimators.api import PoseEstimator
from warehouse_sim.estimators.gravity import upright_frame
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.pose.faces.answer import describe, without_walls
from warehouse_sim.estimators.pose.faces.level import Leveling, find_down
from warehouse_sim.estimators.pose.faces.planes import PlaneView, SolidPlane, face_planes, fit_plane, view_plane
from warehouse_sim.estimators.pose.faces.shape import ANY_PALLET, CatalogFace, catalog_faces
from warehouse_sim.estimators.pose.faces.template import FaceLikelihood, FrontFit, fit_face
from warehouse_sim.estimators.pose.fitting.hypotheses import masked_points
from warehouse_sim.geometry.pose import Transform, invert, make_transform, rotation_x, transform_points
from warehouse_sim.schema import PalletFace, PoseEstimate

_PLANES = 3
"""Upright planes that are looked at."""
_ROUNDS = 2
"""How often plane and face are fitted in turn."""
_CATALOG_SPREAD = 0.004
"""How far pallets are from a CAD that is named (m)."""
_RANGE_BIAS = 0.01
"""Standard deviation of what all readings are off together (m)."""
_LEAST_OPENINGS = 6.0
"""Log likelihood that the pockets must add; with less there is no answer."""
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


class FaceEstimator(PoseEstimator):
    """Fits a parametric face to the depth of each detection.

    Args:
        seed: Decides which points are used.
    """

    reads_rgb = False
    learns_objects = True

    def __init__(self, seed: int = 0) -> None:
        self._seed = seed
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
        level = find_down(image, rng)
        found = [self._estimate(image, index, item, level) for index, item in enumerate(image.detections)]
        seconds = time.perf_counter() - started
        return [replace(item, time=seconds) for item in found if item is not None]

    def _estimate(self, image: RgbdImage, position: int, detection: Detection, level: Leveling) -> PoseEstimate | None:
        number = detection.number_at(position)
        rng = np.random.default_rng([self._seed, image.scene_id, image.image_id, number])
        mask = detection.pixels(*image.depth.shape)
        points = masked_points(image, mask, rng)
        if len(points) < _LEAST_POINTS:
            return None
        info = self._known(detection)
        best: tuple[_Found, CatalogFace | None] | None = None
        for side in _sides(info):
            found = _Search(image, mask, detection.mask is not None, points, level, side, rng).run()
            if found and (best is None or found.fit.score > best[0].fit.score):
                best = found, side
        if best is None or best[0].fit.openings < _LEAST_OPENINGS or best[0].fit.score <= 0.0:
            return None
        found, side = best
        face = describe(found.view.T_camera_plane, found.fit, found.plane, found.roll, _RANGE_BIAS)
        score = detection.score * probability_of_entry(face)
        if info is None or side is None:
            pose, obj_id, name, class_name = face.T_camera_dock, 0, "", "pallet"
        else:
            pose = face.T_camera_dock @ invert(side.T_object_dock)
            obj_id, name, class_name = info.obj_id, info.name, info.class_name
        return PoseEstimate(
            image.scene_id, image.image_id, obj_id, score, pose,
            name=name, class_name=class_name, detection=number, face=face,
        )  # fmt: skip

    def _known(self, detection: Detection) -> ObjectInfo | None:
        if detection.model is None:
            return None
        if detection.model not in self._models:
            raise InputError(f"the estimator was not shown the object {detection.model!r}")
        return self._models[detection.model]


def _sides(info: ObjectInfo | None) -> list[CatalogFace | None]:
    """Return the sides of an object that may be seen; None for one of any pallet."""
    if info is None:
        return [None]
    sides = catalog_faces(info.size, info.pockets, _CATALOG_SPREAD)
    # Opposite sides are alike: the one is as good as the other.
    return list({tuple(np.round(side.prior.usual[2:], 3)): side for side in sides}.values())


@dataclass(frozen=True, eq=False)
class _Search:
    """The search for one detection's face."""

    image: RgbdImage
    mask: Bool[np.ndarray, "h w"]
    masked: bool
    """Whether the detection has a mask, and not only a box."""
    points: Float[np.ndarray, "p 3"]
    """Of the mask (camera frame, m)."""
    level: Leveling
    side: CatalogFace | None
    """Which side it is, where a CAD is named."""
    rng: np.random.Generator

    def run(self) -> _Found | None:
        """Return the face that fits best on any plane, or None where none fits."""
        R = upright_frame(self.level.down)
        T_camera_upright = make_transform(R, np.zeros(3))
        tolerance = 0.015 + 0.008 * float(np.median(self.points[:, 2]))
        best: tuple[PlaneView, FrontFit, float] | None = None
        for T in face_planes(self.points @ R, tolerance, _PLANES, self.rng):
            found = self._look(T_camera_upright @ T, tolerance)
            if found and (best is None or found[1].score > best[1].score):
                best = found
        if best is None:
            return None
        view, fit, sigma = best
        roll, leaned, plane = self.level.roll, 0.0, None
        if self.level.roll > _SURE_ROLL:
            view, fit, roll = self._roll(view, fit, sigma)
        for _ in range(_ROUNDS):
            before = view.T_camera_plane
            plane = fit_plane(view, fit.shape, sigma, (-leaned, self.level.pitch))
            leaned += float(np.arcsin(np.clip(-(before[:3, 2] @ plane.T_camera_plane[:3, 0]), -1, 1)))
            sigma = float(np.clip(plane.sigma, 0.003, 0.06))
            view = self._seen_again(view, plane.T_camera_plane)
            again = self._face(view, sigma, _about(fit), max(plane.dependent, 4.0), starts=2)
            if again is None:
                return None
            fit = again
        assert plane is not None
        return _Found(view, without_walls(fit, view, sigma, self.side is not None), plane, roll)

    def _look(self, T_camera_plane: Transform, tolerance: float) -> tuple[PlaneView, FrontFit, float] | None:
        """Return what a plane shows, the face that fits best, and the error of readings."""
        inside = transform_points(invert(T_camera_plane), self.points)
        on = np.abs(inside[:, 0]) <= tolerance
        if on.sum() < _LEAST_POINTS // 2:
            return None
        seen = np.quantile(inside[on, 1:], 0.01, axis=0), np.quantile(inside[on, 1:], 0.99, axis=0)
        low, high = seen[0] - _AROUND, seen[1] + _AROUND
        pixel = float(T_camera_plane[2, 3]) / self.image.camera.fx
        cell = max(0.003, 0.8 * pixel, float((high - low).max()) / _MOST_CELLS)
        view = view_plane(self.image, self.mask, T_camera_plane, low, high, cell)
        sigma = float(np.clip(1.4826 * np.median(np.abs(inside[on, 0])), 0.004, 0.05))
        fit = self._face(view, sigma, seen)
        return None if fit is None else (view, fit, sigma)

    def _roll(self, view: PlaneView, fit: FrontFit, sigma: float) -> tuple[PlaneView, FrontFit, float]:
        """Return view and face after the turn in the plane that makes edges straightest, and how sure it is (rad)."""
        unsure = self.level.roll
        tried = {0.0: (fit.score, view, fit)}
        for steps in (_ROLLS, _FINER_ROLLS):
            middle = max(tried, key=lambda turn: tried[turn][0])
            for turn in (middle + step * unsure for step in steps):
                T = view.T_camera_plane @ make_transform(rotation_x(turn), np.zeros(3))
                turned = self._seen_again(view, T)
                if found := self._face(turned, sigma, _about(fit)):
                    tried[turn] = found.score - 0.5 * (turn / unsure) ** 2, turned, found
        turns = np.array(list(tried))
        worth = np.array([item[0] for item in tried.values()])
        best = turns[worth.argmax()]
        weight = np.exp(worth - worth.max())
        spread = weight @ (turns - best) ** 2 / weight.sum() + (_FINER_ROLLS[-1] / 2.0 * unsure) ** 2
        return tried[best][1], tried[best][2], float(np.sqrt(spread))

    def _seen_again(self, view: PlaneView, T_camera_plane: Transform) -> PlaneView:
        """Return the same rectangle of another plane."""
        low, high = view.low, view.low + view.cell * np.array(view.behind.shape[::-1])
        return view_plane(self.image, self.mask, T_camera_plane, low, high, view.cell)

    def _face(
        self,
        view: PlaneView,
        sigma: float,
        seen: tuple[Float[np.ndarray, " 2"], Float[np.ndarray, " 2"]],
        dependent: float = 9.0,
        starts: int = 1,
    ) -> FrontFit | None:
        prior = self.side.prior if self.side else ANY_PALLET
        return fit_face(FaceLikelihood(view, sigma, dependent, self.masked), prior, seen, self.rng, starts)


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
