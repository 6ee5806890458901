"""The fields of a torch view: arrays of an observation, padded so that those of all observations have one shape."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from warehouse_sim.api.observation import Observation
from warehouse_sim.api.observation.labelled_object import LabelledObject
from warehouse_sim.errors import UnknownNameError
from warehouse_sim.optional import require_extra

if TYPE_CHECKING:
    from warehouse_sim.learning.samples.torch_data import TorchData

Array = np.ndarray[Any, Any]
_OF_OBJECTS: dict[str, tuple[type, Callable[[LabelledObject], Any]]] = {
    "poses": (np.float32, lambda o: o.T_camera_object),
    "obj_ids": (np.int64, lambda o: o.obj_id),
    "instance_ids": (np.int64, lambda o: o.instance_id),
    "visible_fractions": (np.float32, lambda o: o.visible_fraction),
    "boxes_2d": (np.float32, lambda o: o.box_2d),
    "boxes_3d": (np.float32, lambda o: o.box_3d),
    "masks": (np.bool_, lambda o: o.mask),
    "amodal_masks": (np.bool_, lambda o: o.amodal_mask),
}
"""Type and value of each field with a row an object."""
_ROW_SHAPES = {"poses": (4, 4), "boxes_2d": (4,), "boxes_3d": (8, 3)}
_OF_IMAGE: dict[str, Callable[[Observation], Array]] = {
    "rgb": lambda obs: obs.rgb.transpose(2, 0, 1),
    "depth": lambda obs: obs.depth[None],
    "instance_mask": lambda obs: obs.instance_mask,
}
"""Fields whose last two axes are the image's."""
_OTHERS = ("K", "points", "lidar")
FIELDS = (*_OF_IMAGE, *_OTHERS, *_OF_OBJECTS)


def torch_view(data: Sequence[Observation], fields: Sequence[str]) -> "TorchData":
    """Return observations as a dataset of torch.

    Raises:
        UnknownNameError: There is no such field.
        DatasetError: The dataset does not hold it.
        MissingPackageError: torch is not installed.
    """
    for name in fields:
        if name not in FIELDS:
            raise UnknownNameError("field of observations", name, list(FIELDS))
    require_extra("learn", "for Dataset.torch")
    from warehouse_sim.learning.samples.torch_data import TorchData

    reader = FieldReader(tuple(dict.fromkeys(fields)), Largest.of(data, "lidar" in fields))
    if len(data):
        reader(data[0])  # what the dataset lacks is said here, not in a worker process of a loader
    return TorchData(data, reader)


@dataclass(frozen=True)
class Largest:
    """The shapes that all observations are padded to."""

    height: int
    width: int
    objects: int
    lidar: int

    @classmethod
    def of(cls, data: Iterable[Observation], with_lidar: bool) -> "Largest":
        """Look through the labels, and where it is requested through all sweeps."""
        height = width = objects = lidar = 0
        for obs in data:
            height, width = max(height, obs.camera.height), max(width, obs.camera.width)
            objects = max(objects, len(obs.objects))
            lidar = max(lidar, len(_sweep(obs))) if with_lidar else 0
        return cls(height, width, objects, lidar)


@dataclass(frozen=True)
class FieldReader:
    """Reads the fields of an observation; it crosses to the worker processes of a loader."""

    fields: tuple[str, ...]
    largest: Largest

    def __call__(self, obs: Observation) -> dict[str, Array | int]:
        """Return arrays by name, and the numbers of scene and image."""
        found: dict[str, Array | int] = {"scene_id": obs.scene_id, "image_id": obs.image_id}
        if any(name in _OF_OBJECTS for name in self.fields):
            found["valid"] = np.arange(self.largest.objects) < len(obs.objects)
        for name in self.fields:
            found |= self._field(name, obs)
        return found

    def _field(self, name: str, obs: Observation) -> dict[str, Array | int]:
        size = self.largest
        if name in _OF_IMAGE:
            image = _OF_IMAGE[name](obs)
            return {name: _padded(image, (*image.shape[:-2], size.height, size.width))}
        if name == "K":
            return {name: obs.camera.K.astype(np.float32)}
        if name in ("points", "lidar"):
            points, count = (obs.points, size.height * size.width) if name == "points" else (_sweep(obs), size.lidar)
            return {name: _padded(points, (count, 3)), f"{name}_valid": np.arange(count) < len(points)}
        kind, value = _OF_OBJECTS[name]
        row = (size.height, size.width) if name.endswith("masks") else _ROW_SHAPES.get(name, ())
        rows: Array = np.zeros((size.objects, *row), kind)
        for number, item in enumerate(obs.objects):
            rows[number] = _padded(np.asarray(value(item), kind), row)
        return {name: rows}


def _sweep(obs: Observation) -> Array:
    return np.zeros((0, 3), np.float32) if obs.lidar is None else obs.lidar


def _padded(array: Array, shape: tuple[int, ...]) -> Array:
    """Return an array with zeros behind it along each axis."""
    padded = np.zeros(shape, array.dtype)
    padded[tuple(slice(length) for length in array.shape)] = array
    return padded
