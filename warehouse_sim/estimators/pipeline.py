"""A pose estimator as a pipeline of stages, each of which can be another's.

detect | segment -> select points -> propose -> choose -> refine -> verify; ``tracking`` follows over the images of a
drive. ``WithFrontEnd`` puts detectors and segmenters before an estimator that is no pipeline.
"""

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np
from jaxtyping import Bool, Float, Float32

from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.estimators.api import KnownObject, PoseEstimator, WrappedEstimator
from warehouse_sim.estimators.gravity import Direction
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.matching import described, known_among, observed, taken_by
from warehouse_sim.estimators.pose.choose import Candidates
from warehouse_sim.geometry.pose import Transform, Transforms
from warehouse_sim.schema import Agreement, Observation, PoseEstimate

if TYPE_CHECKING:
    from warehouse_sim.estimators.pose.fitting.verification import DepthView


class ObjectPoints(Protocol):
    """What is looked at of one detection; who derives from it has the defaults of what it does not say."""

    @property
    def position(self) -> int:
        """Position of the detection among those of its image."""

    @property
    def obj_id(self) -> int:
        """Which object it is taken for."""

    @property
    def points(self) -> Float32[np.ndarray, "p 3"]:
        """Its points in the camera frame (m), in random order."""

    @property
    def masked_points(self) -> Float32[np.ndarray, "q 3"]:
        """Those of the points that its mask holds."""
        return self.points

    @property
    def down(self) -> Direction | None:
        """Gravity, a unit vector in the camera frame; None if unknown."""
        return None

    @property
    def bonus(self) -> float:
        """What the detection says for this object, in units of the verification, <= 0: see ``kind_bonus``."""
        return 0.0

    @property
    def view(self) -> "DepthView | None":
        """The image that it is cut out of, for what judges poses by it."""
        return None


class Proposals(Protocol):
    """Poses of b objects; the refiners of whoever proposed them may find more in it."""

    @property
    def candidates(self) -> Candidates:
        """The poses, one or many for each object."""

    def trusted(self, row: int, points: Float[np.ndarray, "p 3"]) -> Bool[np.ndarray, " p"]:
        """Return which points (camera frame, m) around an object are taken for the object's; all by default."""
        return np.ones(len(points), dtype=bool)


FindDetections = Callable[[RgbdImage], Sequence[Detection]]
"""Detects, or outlines what was detected, for the next stage: any ``FrontEnd`` is such."""
SelectPoints = Callable[[RgbdImage], Sequence[ObjectPoints]]
"""Takes those detections out of an image that show enough; one of an unknown model once for each object it may be."""
Propose = Callable[[Sequence[ObjectPoints]], Proposals]
"""Gives the poses that each of b >= 1 objects may have."""
Choose = Callable[[Candidates, Sequence[ObjectPoints]], Transforms]
"""Makes one ``T_camera_object`` of many for each object, (b 4 4)."""
Refine = Callable[[Transforms, Sequence[ObjectPoints], Proposals], Transforms]
"""Makes poses better, (b 4 4)."""
Agree = Callable[[Transforms, Sequence[ObjectPoints], Proposals], Sequence[Agreement]]
"""Says how far the proposals of each object agree with its pose."""
Prefer = Callable[[Transforms, Sequence[ObjectPoints], Proposals], Float[np.ndarray, " b"]]
"""Says how much speaks for each object in its pose, to compare those that one detection may be."""


class Verdict(NamedTuple):
    """What is thought of a pose."""

    score: float
    """Trust in it, 0-1."""
    predicted_error: float | None = None
    """Error that is as likely exceeded as not (m)."""
    error_bound: float | None = None
    """Error that is exceeded in one case of ten (m)."""


_EVEN, _SLOPE = 0.3, 6.0
"""The verification at which a pose is as likely wrong as right, and how steeply that changes: what looked like a pallet
to a detector has rarely more."""


def _chance(verification: float) -> float:
    """Return how likely a pose is right by what the depth image says of it, 0-1."""
    return 1.0 / (1.0 + math.exp(-_SLOPE * (verification - _EVEN)))


Verify = Callable[[Transform, ObjectPoints, float], Verdict | None]
"""Judges a pose by its points and the largest confidence among its proposals (0-1); None rejects it."""


def passed(image: RgbdImage, stages: Sequence[FindDetections]) -> RgbdImage:
    """Return an image with what some stages find in it, each working on what the one before found."""
    for stage in stages:
        image = replace(image, detections=tuple(stage(image)))
    return image


def trust_confidence(T_camera_object: Transform, seen: ObjectPoints, confidence: float) -> Verdict:
    """Return the confidence as it is."""
    return Verdict(confidence)


@dataclass(frozen=True, eq=False)
class Stages:
    """One pipeline, from left to right."""

    select: SelectPoints
    propose: Propose
    choose: Choose
    detect: tuple[FindDetections, ...] = ()
    """One after the other; none where images bring their detections."""
    refine: tuple[Refine, ...] = ()
    """One after the other."""
    verify: Verify = trust_confidence
    agree: Agree | None = None
    """Says how far proposals agree with the pose; None where nobody asks."""
    prefer: Prefer | None = None
    """Decides which object a detection of an unknown model is, and how far a pose is trusted beside others of its
    image; None takes the verdict for both."""


class Pipeline(PoseEstimator):
    """Run the stages over all objects of some images at once.

    Args:
        stages: What is run.
        objects: What it knows, with names and classes; None where it takes any object.
    """

    def __init__(self, stages: Stages, objects: Sequence[KnownObject] | None = None) -> None:
        self.stages, self._objects = stages, objects

    @property
    def objects(self) -> Sequence[KnownObject] | None:
        """What it knows; None where it takes any object."""
        return self._objects

    def estimate(self, image: RgbdImage | Observation) -> list[PoseEstimate]:
        """Return the poses of the detected objects of one image, in order of detections.

        A detection that shows too little gets no estimate; ``PoseEstimate.detection`` says which one each belongs to.
        Of a simulated observation, the labelled objects that are known are estimated.

        Raises:
            InputError: A detection is of an object that is not known, or the image lacks what is read.
        """
        return self.estimate_all([observed(self, image)])

    def estimate_all(self, images: Sequence[RgbdImage]) -> list[PoseEstimate]:
        """Return the poses of the detected objects of several images, which pass the stages together.

        The time of an estimate is that of its image, which counts with its fraction by objects of what is batched.
        """
        seen, owners, seconds, found = list[ObjectPoints](), list[int](), list[float](), list[RgbdImage]()
        for number, image in enumerate(images):
            started = time.perf_counter()
            image = passed(image, self.stages.detect)
            selected = self.stages.select(image)
            seen += selected
            owners += [number] * len(selected)
            seconds.append(time.perf_counter() - started)
            found.append(image)
        if not seen:
            return []
        started = time.perf_counter()
        T, proposals = self._posed(seen)
        confidence = proposals.candidates.confidence.max(axis=1)
        agreed = self.stages.agree(T, seen, proposals) if self.stages.agree else [None] * len(seen)
        fraction = (time.perf_counter() - started) / len(seen)
        times = [spent + fraction * owners.count(number) for number, spent in enumerate(seconds)]
        preferred = self.stages.prefer(T, seen, proposals) if self.stages.prefer else [None] * len(seen)
        best: dict[tuple[int, int], tuple[float, PoseEstimate]] = {}
        rows = zip(owners, seen, T, confidence, agreed, preferred, strict=True)
        for owner, item, pose, trust, agreement, preference in rows:
            if verdict := self.stages.verify(pose, item, float(trust)):
                score, error, bound = verdict
                known, place = self.objects or (), (found[owner], item.position, item.obj_id)
                estimate = described(*place, known, score, pose, times[owner])
                estimate = replace(estimate, predicted_error=error, error_bound=bound, agreement=agreement)
                # A detection of an unknown model was tried as each object.
                worth = estimate.score
                if preference is not None:
                    worth = float(preference) + item.bonus
                    estimate = replace(estimate, score=estimate.score * _chance(float(preference)))
                rival = worth, estimate
                key = owner, item.position
                best[key] = max(best.get(key, rival), rival, key=lambda pair: pair[0])
        return [estimate for _, estimate in best.values()]

    def estimate_objects(self, seen: Sequence[ObjectPoints]) -> tuple[Transforms, Float[np.ndarray, " b"]]:
        """Return ``T_camera_object`` (b 4 4) and the largest confidence among the proposals of at least one object."""
        T, proposals = self._posed(seen)
        return T, proposals.candidates.confidence.max(axis=1)

    def _posed(self, seen: Sequence[ObjectPoints]) -> tuple[Transforms, Proposals]:
        stages = self.stages
        proposals = stages.propose(seen)
        T = stages.choose(proposals.candidates, seen)
        for refine in stages.refine:
            T = refine(T, seen, proposals)
        return T, proposals


class WithFrontEnd(WrappedEstimator):
    """A pose estimator that finds the objects of an image itself, where the image brings no detections.

    Args:
        estimator: What estimates the poses of what is found.
        stages: What finds it, one after the other.
        objects: Names of the objects that there are; by default those that it is shown, and all that the estimator
            knows before it is shown any.
    """

    finds_objects = True
    reads_rgb = True

    def __init__(self, estimator: PoseEstimator, stages: Sequence[FindDetections], objects: Sequence[str] = ()) -> None:
        super().__init__(estimator)
        self._stages = tuple(stages)
        self._given = self._names = tuple(objects)

    def onboard(self, objects: Mapping[int, ObjectInfo]) -> None:
        """Take what is found for one of these objects, by obj_id, unless their names were given."""
        self.inner.onboard(objects)
        self._names = self._given or known_among(self.inner, objects)

    def estimate(self, image: RgbdImage) -> list[PoseEstimate]:
        """Return the poses of what the image brings, or of what is found in it; times count the finding."""
        return self.estimate_all([image])

    def estimate_all(self, images: Sequence[RgbdImage]) -> list[PoseEstimate]:
        """Return what ``estimate`` returns for each image, one after the other."""
        found, seconds = list[RgbdImage](), dict[tuple[int, int], float]()
        for image in images:
            started = time.perf_counter()
            found.append(image if image.detections else self._with_detections(image))
            seconds[image.scene_id, image.image_id] = time.perf_counter() - started
        seen = [image for image in found if image.detections]
        poses = self.inner.estimate_all(seen) if seen else []
        return [
            replace(pose, time=pose.time + seconds[pose.scene_id, pose.image_id]) if pose.time >= 0 else pose
            for pose in poses
        ]

    def _with_detections(self, image: RgbdImage) -> RgbdImage:
        found = passed(image, self._stages).detections
        return replace(image, detections=taken_by(self.inner, found, self._names))
