"""Tracks of one drive: which estimate belongs to which, what each says so far, and what is given for an image."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float
from scipy.optimize import linear_sum_assignment

from warehouse_sim.estimators.tracking.belief import Belief, Matrix6, Measurement, Vector6, difference, mahalanobis
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, invert
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.schema import PoseEstimate

_FAR = 1e6
_DEGREES_OF_FREEDOM = 4.0
"""Of the Student's t that errors are taken to follow: what is far out counts less."""
_SAME_PLACE = 0.4
"""Tracks of one model nearer than this (m) are rivals: two poses of one object, of which one is given."""
_LEAST_SUPPORT = 1.0
"""Sum of the scores that a track needs to be given without a detection."""
_GATE = 22.46
"""Largest squared Mahalanobis distance between an estimate and its track: 99.9 % of chi-squared, six degrees."""
_MAX_AGE = 3.0
"""For so long (s) a track is given where nothing was detected but its object should be in the image."""
# Errors that all estimates of a track have in common, which no number of images averages out: choices without a source.
_COMMON_FRACTION = 0.3
"""Of an estimate's covariance: a CAD model that differs from the object, boards that hide, a side never seen."""
_COMMON_DEPTH, _COMMON_DEPTH_FRACTION = 0.003, 0.002
"""Along the ray (m), and what it grows by as a fraction of the range."""
_COMMON_SIDE = 0.002
"""Across the ray (m): where the camera is said to be mounted."""
_COMMON_TURN = np.deg2rad(0.1)
"""Of how the camera is said to be turned (rad)."""


@dataclass(frozen=True, eq=False)
class View:
    """Where and when an image was taken."""

    scene_id: int
    image_id: int
    camera: PinholeCamera
    T_world_camera: Transform
    time: float
    """Seconds since the drive began."""


@dataclass(eq=False)
class Track:
    """One object, or one of the poses that it may have."""

    belief: Belief
    last: PoseEstimate
    """The estimate that came last."""
    time: float
    support: float = 0.0
    """Sum of the scores of its estimates."""
    score: float = 0.0
    """Largest of them."""
    images: set[int] = field(default_factory=set)
    """In which images of the drive it was estimated."""


@dataclass(eq=False)
class Tracker:
    """Filters the estimates of one drive, image by image.

    Args:
        symmetries: Of the objects by obj_id; those of others are taken for asymmetric.
        drift: What a second adds to the uncertainty of where an object is seen from (m at one second, growing with the
            root of time); 0 for a vehicle that knows where it is.
    """

    symmetries: Mapping[int, SymmetryGroup]
    drift: float = 0.0
    tracks: list[Track] = field(default_factory=list)
    now: float | None = None
    """Time of the last image (s)."""
    count: int = 0
    """Images so far."""

    def step(self, view: View, estimates: Sequence[PoseEstimate]) -> list[PoseEstimate]:
        """Return what is known after one more image, in the order of its estimates, then what was not detected.

        Each estimate is given with the pose, covariance and score of its object's best supported track; one without a
        covariance, or that was rejected, is given as it is and changes nothing.

        Args:
            view: The image.
            estimates: What was estimated in it.
        """
        passed = max(view.time - self.now, 0.0) if self.now is not None else 0.0
        self.now, self.count = view.time, self.count + 1
        for track in self.tracks:
            track.belief = track.belief.after(self.drift**2 * passed)
        taken = [item for item in estimates if item.covariance is not None and not item.rejected]
        seen = [in_world(item, view.T_world_camera) for item in taken]
        own = {id(item): track for item, track in zip(taken, self._associate(taken, seen), strict=True)}
        given, used = list[PoseEstimate](), list[Track]()
        for item in estimates:
            if id(item) not in own:
                given.append(item)
                continue
            best = self._best_rival(own[id(item)])
            # Of two estimates of one object the second is given as its own track has it.
            best = own[id(item)] if best in used else best
            used += [best, own[id(item)]]
            given.append(_as_estimate(best, item, view))
        return given + self._ageing(view, used, given)

    def _associate(self, taken: Sequence[PoseEstimate], seen: Sequence[Measurement]) -> list[Track]:
        """Return each estimate's own track, updated by it; a new one where none is near enough."""
        before = list(self.tracks)
        cost = np.full((len(taken), len(before)), _FAR)
        for row, (item, measured) in enumerate(zip(taken, seen, strict=True)):
            for column, track in enumerate(before):
                if track.last.obj_id == item.obj_id:
                    distance = self._nearest(track, item, measured)[1]
                    cost[row, column] = distance if distance <= _GATE else _FAR
        pairs = dict(zip(*(part.tolist() for part in linear_sum_assignment(cost)), strict=True))
        found = []
        for row, (item, measured) in enumerate(zip(taken, seen, strict=True)):
            nearest = pairs.get(row)
            if nearest is None or cost[row, nearest] >= _FAR:
                found.append(Track(Belief.of(measured), item, self.now or 0.0))
                self.tracks.append(found[-1])
            else:
                found.append(self._update(before[nearest], item, measured))
            track = found[-1]
            track.last, track.time = item, self.now or 0.0
            track.images.add(self.count)
            track.support, track.score = track.support + item.score, max(track.score, item.score)
        return found

    def _update(self, track: Track, item: PoseEstimate, measured: Measurement) -> Track:
        T, distance = self._nearest(track, item, measured)
        # What six numbers give on average, or less, counts in full; what is far out less (Lange et al. 1989).
        weight = min(1.0, (_DEGREES_OF_FREEDOM + 6.0) / (_DEGREES_OF_FREEDOM + distance))
        track.belief = track.belief.updated(replace(measured, T_world_object=T), weight)
        return track

    def _nearest(self, track: Track, item: PoseEstimate, measured: Measurement) -> tuple[Transform, float]:
        symmetry = self.symmetries.get(item.obj_id, SymmetryGroup.trivial())
        covariance = track.belief.apart(measured)
        T, _, distance = nearest_equivalent(measured.T_world_object, track.belief.T_world_object, covariance, symmetry)
        return T, distance

    def _are_rivals(self, one: Track, other: Track) -> bool:
        """Return whether two tracks are of one place, one model, and were never estimated in one image."""
        if one.last.obj_id != other.last.obj_id or one.images & other.images:
            return False
        apart = one.belief.T_world_object[:3, 3] - other.belief.T_world_object[:3, 3]
        return bool(np.linalg.norm(apart) < _SAME_PLACE)

    def _best_rival(self, own: Track) -> Track:
        """Return the best supported of a track and its rivals."""
        rivals = [track for track in self.tracks if self._are_rivals(own, track)]
        return max([own, *rivals], key=lambda track: track.support)

    def _ageing(self, view: View, used: list[Track], given: Sequence[PoseEstimate]) -> list[PoseEstimate]:
        """Return supported tracks of objects that should be in the image, but of which nothing was estimated there."""
        found = []
        for track in self.tracks:
            recent = view.time - track.time <= _MAX_AGE and track.support >= _LEAST_SUPPORT
            if not recent or any(track is other or self._are_rivals(track, other) for other in used):
                continue
            if in_sight(view, track.belief.T_world_object[:3, 3]) and self._best_rival(track) is track:
                time = given[0].time if given else -1.0
                blank = replace(track.last, detection=-1, time=time, face=None, agreement=None)
                found.append(_as_estimate(track, blank, view))
        return found


def _as_estimate(track: Track, item: PoseEstimate, view: View) -> PoseEstimate:
    """Return an estimate of this image with the pose and the uncertainty of a track."""
    axes = np.zeros((6, 6))
    axes[:3, :3] = axes[3:, 3:] = view.T_world_camera[:3, :3].T
    covariance = axes @ track.belief.covariance @ axes.T
    return replace(
        item,
        scene_id=view.scene_id,
        image_id=view.image_id,
        T_camera_object=invert(view.T_world_camera) @ track.belief.T_world_object,
        covariance=0.5 * (covariance + covariance.T),
        score=track.score,
    )


def in_sight(view: View, place: Float[np.ndarray, " 3"]) -> bool:
    """Return whether a place (m, world) lies before the camera and in its image."""
    x, y, z = (invert(view.T_world_camera) @ np.append(place, 1.0))[:3]
    if z < 0.3:
        return False
    low_x, high_x, low_y, high_y = view.camera.tangent_bounds()
    return bool(low_x <= x / z <= high_x and low_y <= y / z <= high_y)


def in_world(estimate: PoseEstimate, T_world_camera: Transform) -> Measurement:
    """Return the estimate as seen from the world.

    Args:
        estimate: With a covariance.
        T_world_camera: Where its camera was.
    """
    assert estimate.covariance is not None
    axes = np.zeros((6, 6))
    axes[:3, :3] = axes[3:, 3:] = T_world_camera[:3, :3]
    covariance = np.asarray(estimate.covariance, dtype=float)
    place = estimate.T_camera_object[:3, 3]
    common = np.hstack([np.sqrt(_COMMON_FRACTION) * _root(covariance), _of_camera(place)])
    # A direction without any uncertainty would be a measurement that no other can correct.
    own = (1.0 - _COMMON_FRACTION) * covariance + np.diag([1e-4] * 3 + [1e-4] * 3) ** 2
    return Measurement(T_world_camera @ estimate.T_camera_object, axes @ own @ axes.T, axes @ common)


def nearest_equivalent(
    T_world_object: Transform, T_world_track: Transform, covariance: Matrix6, symmetry: SymmetryGroup
) -> tuple[Transform, Vector6, float]:
    """Return which of the poses that look the same is nearest to a track, its distance, and that in deviations squared.

    Args:
        T_world_object: Any of the equivalent poses.
        T_world_track: The track's pose.
        covariance: Of the distance between them (m, rad).
        symmetry: Of the object.
    """
    steps = [(T, difference(T, T_world_track)) for T in symmetry.equivalents(T_world_object)]
    found = [(T, step, mahalanobis(step, covariance)) for T, step in steps]
    return min(found, key=lambda item: item[2])


def _root(covariance: Matrix6) -> Matrix6:
    """Return the symmetric root, so that one common error leads the same way in every image."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray((vectors * np.sqrt(np.maximum(values, 0.0))) @ vectors.T)


def _of_camera(place: Float[np.ndarray, " 3"]) -> Float[np.ndarray, "6 6"]:
    """Return what a camera's common errors do to the pose (camera axes) of something at a place (m) before it.

    Columns: an error of depth, two of where the camera is across its view, three of how it is turned.
    """
    reach = float(np.linalg.norm(place))
    effect = np.zeros((6, 6))
    effect[:3, 0] = place / reach * (_COMMON_DEPTH + _COMMON_DEPTH_FRACTION * reach)
    effect[0, 1] = effect[1, 2] = _COMMON_SIDE
    x, y, z = place
    effect[:3, 3:] = _COMMON_TURN * np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    effect[3:, 3:] = _COMMON_TURN * np.eye(3)
    return effect
