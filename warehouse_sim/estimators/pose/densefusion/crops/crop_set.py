"""Crops as tensors: no decoding and no loader while training."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from jaxtyping import Bool, Float, Float16, Int, Int8, Int16, UInt8
from torch import Tensor

from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.estimators.pose.densefusion.crops.cut import Crop, image_crops
from warehouse_sim.estimators.pose.densefusion.crops.surround import Surroundings
from warehouse_sim.estimators.pose.densefusion.objects import ObjectShape
from warehouse_sim.estimators.pose.densefusion.settings import CropConfig
from warehouse_sim.learning.samples.array_store import Arrays, shared_tensor
from warehouse_sim.learning.samples.split import load_rows, split_digest, split_images


class CropTable(NamedTuple):
    """K crops with capacity for P points each, a row each; points beyond ``point_count`` are zero."""

    points: Float[Tensor, "k p 3"]
    """Camera frame (m), float32."""
    border_px: UInt8[Tensor, "k p"]
    point_count: Int[Tensor, " k"]
    class_index: Int[Tensor, " k"]
    diameter: Float[Tensor, " k"]
    """Metres."""
    T_camera_object: Float[Tensor, "k 4 4"]
    """Float64, so that metres keep their micrometres until the cloud is centred."""
    pixel: Int16[Tensor, "k p"] | None = None
    """Row-major index into the square crop; none without a square crop."""
    rgb: UInt8[Tensor, "k s s 3"] | None = None
    depth: Float16[Tensor, "k s s"] | None = None
    """Metres beyond ``depth_base``, NaN = no reading. Within 2 m of it the rounding is below 0.5 mm, half of what the
    millimetres of the depth files leave."""
    depth_base: Float[Tensor, " k"] | None = None
    """Median depth of the points (m)."""
    ray_map: Float[Tensor, "k 2 3"] | None = None
    """Maps (column, row, 1) of the depth crop's pixels to their rays (x / z, y / z)."""
    down: Float[Tensor, "k 3"] | None = None
    """Gravity in the camera frame, a unit vector; NaN if unknown."""
    signed_px: Int8[Tensor, "k p"] | None = None
    """Pixels to the mask's outline, positive inside; this and what follows only of crops with surroundings."""
    belongs: Bool[Tensor, "k p"] | None = None
    """Whether each point is truly the object's."""
    neighbour: UInt8[Tensor, "k p"] | None = None
    """Which other target of the crop each point belongs to, 0 for none."""
    uv: Int16[Tensor, "k p 2"] | None = None
    """Column and row (image pixels) from the window's upper left pixel."""
    window_px: Float[Tensor, " k"] | None = None
    """Side of the window in image pixels."""
    outline: Int8[Tensor, "k o o"] | None = None
    """``signed_px`` over the window."""

    @property
    def has_surroundings(self) -> bool:
        """Whether points need not be the object's."""
        return self.signed_px is not None

    def rows(self, index: Int[Tensor, " b"]) -> "CropTable":
        """Return copies of the crops ``index``."""
        return self.map(lambda column: column.index_select(0, index))

    def to(self, device: torch.device) -> "CropTable":
        """Return the same crops on ``device``."""
        return self.map(lambda column: column.to(device))

    def map(self, change: Callable[[Tensor], Tensor]) -> "CropTable":
        """Return the table with every column changed alike."""
        columns: list[Any] = [None if column is None else change(column) for column in self]
        return CropTable(*columns)


class CropSet:
    """Crops in one or several tables, numbered through; the tables may lie on disk.

    Args:
        tables: At least one, all with the same columns.
        chosen: Rows of the tables, numbered through, that belong to the set; all by default.
    """

    def __init__(self, tables: Sequence[CropTable], chosen: Int[Tensor, " k"] | None = None) -> None:
        self.tables = tuple(tables)
        self._chosen = chosen
        self._first = torch.tensor([0, *(len(table.points) for table in self.tables)]).cumsum(0)

    def __len__(self) -> int:
        return int(self._first[-1]) if self._chosen is None else len(self._chosen)

    @property
    def class_index(self) -> Int[Tensor, " k"]:
        """Class of each crop."""
        return self._column([table.class_index for table in self.tables])

    @property
    def diameter(self) -> Float[Tensor, " k"]:
        """Diameter of each crop's object (m)."""
        return self._column([table.diameter for table in self.tables])

    @property
    def T_camera_object(self) -> Float[Tensor, "k 4 4"]:
        """True pose of each crop's object (m), float64."""
        return self._column([table.T_camera_object for table in self.tables])

    def rows(self, index: Int[Tensor, " b"]) -> CropTable:
        """Return copies of the crops ``index``, in this order."""
        index = index if self._chosen is None else self._chosen[index]
        if len(self.tables) == 1:
            return self.tables[0].rows(index)
        home = torch.searchsorted(self._first.to(index.device), index, right=True) - 1
        found = [(home == number).nonzero()[:, 0] for number in range(len(self.tables))]
        parts = [
            table.rows(index[places] - first)
            for table, first, places in zip(self.tables, self._first.tolist(), found, strict=False)
        ]
        back = torch.cat(found).argsort()
        return join_tables(parts).rows(back)

    def to(self, device: torch.device) -> "CropSet":
        """Return the same crops on ``device``; tables that lie on disk stay there when it is the CPU.

        Elsewhere they become one: each table that rows are drawn from is a stop of the device and some twenty launches.
        """
        if device.type == "cpu":
            return self
        chosen = None if self._chosen is None else self._chosen.to(device)
        return CropSet([join_tables([table.to(device) for table in self.tables])], chosen)

    def _column(self, parts: list[Tensor]) -> Tensor:
        column = torch.cat(parts)
        return column if self._chosen is None else column[self._chosen]


def stack_crops(crops: Sequence[Crop], shapes: Sequence[ObjectShape], config: CropConfig) -> CropSet:
    """Return ``crops`` as tensors; their objects must be among ``shapes``, whose order numbers the classes."""
    known = {shape.obj_id for shape in shapes}
    assert all(crop.obj_id in known for crop in crops)
    return CropSet([table_of(stack_arrays(crops, config), shapes)])


def stack_arrays(crops: Sequence[Crop], config: CropConfig) -> dict[str, np.ndarray]:
    """Return ``crops`` as arrays by the names of a table's columns, with ``obj_id`` instead of class and diameter."""
    count, capacity = len(crops), config.stored_points
    arrays: dict[str, np.ndarray] = {
        "points": np.zeros((count, capacity, 3), dtype=np.float32),
        "border_px": np.zeros((count, capacity), dtype=np.uint8),
        "point_count": np.array([len(crop.points) for crop in crops], dtype=np.int64),
        "obj_id": np.array([crop.obj_id for crop in crops], dtype=np.int64),
        "T_camera_object": np.stack([crop.T_camera_object for crop in crops]),
        "down": np.array([np.full(3, np.nan) if crop.down is None else crop.down for crop in crops], dtype=np.float32),
    }
    if config.has_surroundings:
        arrays |= _stack_surroundings([crop.around for crop in crops if crop.around is not None], capacity)
    elif config.side_px:
        arrays["pixel"] = np.zeros((count, capacity), dtype=np.int16)
    for row, crop in enumerate(crops):
        for name in ("points", "border_px", "pixel"):
            if name in arrays:
                arrays[name][row, : len(crop.points)] = getattr(crop, name)
    if config.reads_rgb:
        arrays["rgb"] = np.stack([crop.rgb for crop in crops if crop.rgb is not None])
    if config.reads_depth:
        base = np.array([np.median(crop.points[:, 2]) for crop in crops], dtype=np.float32)
        arrays["depth_base"] = base
        arrays["depth"] = np.stack([
            np.where(crop.depth > 0, crop.depth - z, np.nan).astype(np.float16)
            for crop, z in zip(crops, base, strict=True)
            if crop.depth is not None
        ])  # fmt: skip
        arrays["ray_map"] = np.stack([crop.ray_map for crop in crops if crop.ray_map is not None]).astype(np.float32)
    return arrays


def _stack_surroundings(around: Sequence[Surroundings], capacity: int) -> dict[str, np.ndarray]:
    arrays = {
        "signed_px": np.zeros((len(around), capacity), dtype=np.int8),
        "belongs": np.zeros((len(around), capacity), dtype=bool),
        "neighbour": np.zeros((len(around), capacity), dtype=np.uint8),
        "uv": np.zeros((len(around), capacity, 2), dtype=np.int16),
    }
    for row, item in enumerate(around):
        for name, array in arrays.items():
            array[row, : len(item.signed_px)] = getattr(item, name)
    arrays["window_px"] = np.array([item.window_px for item in around], dtype=np.float32)
    arrays["outline"] = np.stack([item.outline for item in around])
    return arrays


def table_of(arrays: dict[str, np.ndarray], shapes: Sequence[ObjectShape]) -> CropTable:
    """Return arrays of ``stack_arrays`` as tensors that share their memory; objects not in ``shapes`` get class -1."""
    number = {shape.obj_id: i for i, shape in enumerate(shapes)}
    classes = torch.tensor([number.get(obj_id, -1) for obj_id in arrays["obj_id"].tolist()])
    diameters = torch.tensor([shape.diameter for shape in shapes], dtype=torch.float32)
    columns = {name: shared_tensor(array) for name, array in arrays.items() if name != "obj_id"}
    return CropTable(**columns, class_index=classes, diameter=diameters[classes])


def join_tables(parts: Sequence[CropTable]) -> CropTable:
    """Return the crops of several tables in one, in their order."""
    columns: list[Any] = [None if column[0] is None else torch.cat(column) for column in zip(*parts, strict=True)]
    return CropTable(*columns)


_FORMAT = 2
"""To be raised when the arrays change."""
CUT_SEED = 0
"""Decides which pixels of large targets are kept: one choice for all trainings, so that they share their crops."""


def load_crops(
    reader: DatasetReader,
    split: str,
    config: CropConfig,
    workers: int,
    cache: Path | None,
    progress: Callable[[float], None] | None = None,
) -> Arrays | None:
    """Return the arrays of ``stack_arrays`` for all wanted targets of a split, or None when it has no usable one.

    Networks with and without colour or depth share one entry of the cache: each takes the columns it reads. Arguments
    and errors are those of ``load_rows``; ``config`` says how to cut.

    Raises:
        TrainingError: No such split, or the cache cannot be written.
    """
    whole = replace(config, rgb=True, depth=True) if config.side_px and cache else config

    def cut(image: ImageRecord) -> Arrays | None:
        crops = list(image_crops(reader, image, whole, CUT_SEED))
        return stack_arrays(crops, whole) if crops else None

    settings = _settings(split, whole)
    arrays = load_rows(reader, split, split_images(reader, split), cut, settings, "crops", workers, cache, progress)
    unwanted = set() if config.reads_rgb else {"rgb"}
    unwanted |= set() if config.reads_depth else {"depth", "depth_base", "ray_map"}
    return None if arrays is None else {name: array for name, array in arrays.items() if name not in unwanted}


def crops_digest(reader: DatasetReader, split: str, config: CropConfig) -> str:
    """Return a text that changes with anything the crops depend on."""
    return split_digest(reader, split, _settings(split, config))


def _settings(split: str, config: CropConfig) -> list[object]:
    return [_FORMAT, CUT_SEED, split, asdict(config)]
