"""Pallets by geometry alone: the rectangle of the face that is seen, no network, nothing to train."""

from collections.abc import Mapping

import numpy as np

from stranger_warehouse.face import fit_face, pallet_pose
from stranger_warehouse.floor import points_of
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.errors import InputError
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.schema import PoseEstimate

_LEAST_FRACTION = 0.15
"""Fraction of the points that must lie on one vertical plane."""


class RectangleEstimator:
    """Fits a rectangle to the depth readings of each detection; the camera must be level.

    The sizes of the objects are those of the dataset's CAD models, which it is shown first.
    """

    objects = None
    reads_rgb = False

    def __init__(self) -> None:
        self._models: dict[int | str, ObjectInfo] = {}

    def onboard(self, objects: Mapping[int, ObjectInfo]) -> None:
        """Take over the sizes, by number and by name."""
        self._models = {**objects, **{item.name: item for item in objects.values()}}

    def estimate(self, image: RgbdImage) -> list[PoseEstimate]:
        """Return a pose for each detection of which a face is seen.

        Raises:
            InputError: A detection is of an object that it was not shown.
        """
        points = points_of(image.depth, image.camera.K)
        found = []
        for position, detection in enumerate(image.detections):
            if detection.model not in self._models:
                raise InputError(f"rectangle: it was not shown the object {detection.model!r}")
            number = position if detection.number is None else detection.number
            model = self._models[detection.model]
            seen = points[np.asarray(detection.mask, bool) & (image.depth > 0)]
            face = fit_face(seen, np.random.default_rng([image.scene_id, image.image_id, number]))
            if face is None or face.fraction < _LEAST_FRACTION:
                continue
            found.append(
                PoseEstimate(
                    image.scene_id,
                    image.image_id,
                    model.obj_id,
                    detection.score * face.fraction,
                    pallet_pose(face, model.size),
                    name=model.name,
                    class_name=model.class_name,
                    detection=number,
                )
            )
        return found
