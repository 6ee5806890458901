"""Which detections an estimator takes, which of the objects that it knows each may be, and what it says of one."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TypeVar

from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.errors import InputError, UnknownNameError
from warehouse_sim.estimators.api import KnownObject, PoseEstimator
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.schema import Observation, PoseEstimate

Known = TypeVar("Known", bound=KnownObject)


def is_known(estimator: PoseEstimator, detection: Detection) -> bool:
    """Return whether an estimator may know what was detected."""
    if estimator.objects is None:
        return True
    if detection.model is None:
        classes = {shape.class_name for shape in estimator.objects}
        return detection.class_name in ("", *classes) or classes == {""}
    return any(detection.model in (shape.obj_id, shape.name) for shape in estimator.objects)


def known_among(estimator: PoseEstimator, objects: Mapping[int, ObjectInfo]) -> tuple[str, ...]:
    """Return the names of those objects, by obj_id, that an estimator knows by the same number and name."""
    return tuple(
        shape.name
        for shape in estimator.objects or ()
        if shape.obj_id in objects and objects[shape.obj_id].name == shape.name
    )


def taken_by(
    estimator: PoseEstimator, found: Sequence[Detection], objects: Sequence[str] = ()
) -> tuple[Detection, ...]:
    """Return the detections of what an estimator knows; those of no model may be one of ``objects``.

    Args:
        estimator: Who takes them.
        found: What was detected.
        objects: Names of the objects that there are; without any, all of a detection's class that are known.

    Raises:
        UnknownNameError: The estimator does not know one of the names.
    """
    known = tuple(item for item in found if is_known(estimator, item))
    if not objects or estimator.objects is None:
        return known
    names = {shape.name: shape.class_name for shape in estimator.objects}
    if strange := [name for name in objects if name not in names]:
        raise UnknownNameError("object of the estimator under --objects", strange[0], list(names))
    limited = list[Detection]()
    for item in known:
        alike = tuple(name for name in objects if item.class_name in ("", names[name]))
        if item.model is not None or item.may_be:
            limited.append(item)
        elif alike:
            limited.append(replace(item, may_be=alike))
    return tuple(limited)


def observed(estimator: PoseEstimator, image: RgbdImage | Observation) -> RgbdImage:
    """Return an image as it is, and a simulated observation as one, with those labelled objects that are known."""
    if isinstance(image, RgbdImage):
        return image
    seen = RgbdImage.from_observation(image)
    known = None if estimator.objects is None else {shape.obj_id for shape in estimator.objects}
    return replace(seen, detections=tuple(item for item in seen.detections if known is None or item.model in known))


_UNLIKELY = 0.1
"""An object that is less likely than this part of the likeliest one is not tried."""
_KIND_WEIGHT = 0.1
"""What a factor e of the likelihood is worth, in units of the verification."""


def may_be(detection: Detection, objects: Sequence[Known]) -> list[Known]:
    """Return those of an estimator's objects that a detection may show; where it names none, all of its class, or all.

    Where the detection says how likely each is, only the likely ones; objects that it does not know are always tried.

    Raises:
        InputError: It names an object that is none of them.
    """
    requested = detection.may_be if detection.model is None else (detection.model,)
    if not requested:
        alike = [item for item in objects if detection.class_name in ("", item.class_name)] or list(objects)
        return _likely(detection, alike)
    by_name = {key: item for item in objects for key in (item.obj_id, item.name)}
    for model in requested:
        if model not in by_name:
            names = ", ".join(f"{item.name} ({item.obj_id})" for item in objects)
            raise InputError(f"the estimator does not know the object {model!r}; it knows: {names}")
    return _likely(detection, [by_name[model] for model in requested])


def _likely(detection: Detection, objects: list[Known]) -> list[Known]:
    likelihood = detection.kind_likelihood
    least = _UNLIKELY * max((likelihood[item.name] for item in objects if item.name in likelihood), default=0.0)
    return [item for item in objects if likelihood.get(item.name, 1.0) >= least]


def kind_bonus(detection: Detection, name: str) -> float:
    """Return what the kind of a detection adds to the verification of one object in its place, at most 0."""
    return _KIND_WEIGHT * math.log(max(detection.kind_likelihood.get(name, 1.0), 1e-6))


def described(
    image: RgbdImage,
    position: int,
    obj_id: int,
    objects: Iterable[KnownObject],
    score: float,
    T_camera_object: Transform,
    seconds: float = -1.0,
) -> PoseEstimate:
    """Return the pose of a detection as an estimate, whose score is that of both.

    Args:
        image: Where it was detected.
        position: Of the detection among those of the image.
        obj_id: Which object it is taken for.
        objects: Where names are looked up.
        score: Trust in the pose, 0-1.
        T_camera_object: The pose.
        seconds: How long it took; below 0 if unknown.
    """
    known, item = next((shape for shape in objects if shape.obj_id == obj_id), None), image.detections[position]
    name, class_name = (known.name, known.class_name) if known else ("", "")
    place = image.scene_id, image.image_id
    return PoseEstimate(
        *place, obj_id, score * item.score, T_camera_object, seconds, name, class_name, item.number_at(position)
    )
