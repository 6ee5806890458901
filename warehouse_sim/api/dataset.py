"""A dataset folder as a sequence of observations."""

import operator
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, SupportsIndex, overload

import numpy as np

from warehouse_sim.api.arguments import checked
from warehouse_sim.api.estimates import chosen_split, estimates_of, method_name, scores_of
from warehouse_sim.api.observation import Observation
from warehouse_sim.api.observation.torch_fields import torch_view
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.dataset.split import require_split
from warehouse_sim.errors import DatasetError, InputError, OutOfRangeError, shown

if TYPE_CHECKING:
    from warehouse_sim.evaluation import Scores
    from warehouse_sim.learning.samples.torch_data import TorchData


class Dataset(Sequence[Observation]):
    """A dataset folder in any readable format: a sequence of observations by scene and image, all splits together.

    Opening it reads labels when they are first needed, and images one by one. A slice or a split of it is a Dataset,
    too.

    Example:
        >>> data = ws.Dataset("out")
        >>> len(data), data[0].scene_id, data[-1].image_id
        (6, 0, 1)
        >>> [len(data.split(name)) for name in data.splits]
        [2, 2, 2]
        >>> data[:2]
        <Dataset smoke at 'out': 2 observations in 1 scene (train 2)>

    Args:
        path: Folder, of this package or a third-party one (BOP, KITTI, COCO, YOLO, LINEMOD, plain images).
    """

    @checked
    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        """The folder."""
        if not self.path.is_dir():
            raise DatasetError(f"{path}: is not a folder; name the folder of a dataset, or generate one")
        self._reader = DatasetReader(self.path)
        self._chosen: tuple[int, ...] | None = None

    def __repr__(self) -> str:
        scenes = len({image.scene_id for image in self._images})
        splits = ", ".join(f"{name} {count}" for name, count in self._count_by_split().items())
        observations = f"{len(self)} observation{'' if len(self) == 1 else 's'}"
        return (
            f"<Dataset {self.name} at {str(self.path)!r}: {observations} in {scenes} "
            f"scene{'' if scenes == 1 else 's'}{f' ({splits})' if splits else ''}>"
        )

    def _repr_html_(self) -> str:
        """Show itself in a notebook."""
        rows = "".join(
            f"<tr><td>{escape(name)}</td><td>{count}</td></tr>" for name, count in self._count_by_split().items()
        )
        return f"<p>{escape(repr(self))}</p><table><tr><th>split</th><th>observations</th></tr>{rows}</table>"

    def __reduce__(self) -> tuple[Any, ...]:
        """Cross to another process as the folder and what is chosen of it."""
        return _reopened, (str(self.path), self._chosen)

    def __len__(self) -> int:
        return len(self._images)

    @overload
    def __getitem__(self, index: SupportsIndex) -> Observation: ...
    @overload
    def __getitem__(self, index: "slice[Any, Any, Any]") -> "Dataset": ...
    def __getitem__(self, index: Any) -> "Observation | Dataset":
        """Return one observation, from the end if the number is negative, or for a slice a Dataset.

        Raises:
            OutOfRangeError: There is no such observation; it is an IndexError, too.
            InputError: ``index`` is neither a whole number nor a slice.
        """
        if isinstance(index, slice):
            return self._part(_places(index, len(self)))
        place = _whole(index)
        if not -len(self) <= place < len(self):
            last = f"0 to {len(self) - 1}" if len(self) else "none, it is empty"
            raise OutOfRangeError(f"{self.path}: there is no observation {place}; there are {last}")
        return Observation(self._reader, self._images[place])

    def __iter__(self) -> Iterator[Observation]:
        return (Observation(self._reader, image) for image in self._images)

    @property
    def name(self) -> str:
        """Name of the recipe that it was made from, or of the folder."""
        return self._reader.name

    @property
    def splits(self) -> dict[str, tuple[int, ...]]:
        """Scene numbers of each split; empty splits included."""
        return {name: tuple(scenes) for name, scenes in self._reader.splits.items()}

    @property
    def objects(self) -> Mapping[int, ObjectInfo]:
        """The CAD geometries of the labels by obj_id: name, class, size (m), diameter (m), symmetries, mesh."""
        return self._reader.objects

    @checked
    def split(self, name: str) -> "Dataset":
        """Return the observations of one split as a Dataset, which may be empty.

        Raises:
            DatasetError: There is no such split.
        """
        require_split(self.path, name, self.scored.splits)
        names = (name,) if name in self._reader.parts else ("train", "val")
        return self._part([place for place, image in enumerate(self._images) if image.split in names])

    @checked
    def torch(self, *fields: str) -> "TorchData":
        """Return it as a map-style dataset of torch, whose items the loader's own collation makes batches of.

        Items are dicts of tensors. Those of objects are padded to the largest number of objects of an observation,
        m, and images at the right and bottom to the largest image, h x w. Every item also holds ``scene_id`` and
        ``image_id``, and with a field of objects ``valid`` (m, bool): which rows are objects.

        - ``rgb`` (3, h, w) uint8; ``depth`` (1, h, w) float32, m, 0 = no reading; ``K`` (3, 3) float32
        - ``points`` (h * w, 3) float32, m, camera frame, and ``points_valid`` (h * w) bool
        - ``lidar`` (n, 3) float32, m, LiDAR frame, n of the largest sweep, and ``lidar_valid`` (n) bool
        - ``poses`` (m, 4, 4) float32, T_camera_object, m; ``obj_ids`` and ``instance_ids`` (m) int64, 0 = none;
          ``visible_fractions`` (m) float32; ``boxes_2d`` (m, 4) float32, px; ``boxes_3d`` (m, 8, 3) float32, m
        - ``masks`` and ``amodal_masks`` (m, h, w) bool; ``instance_mask`` (h, w) int32

        Args:
            fields: What items hold; ``rgb``, ``depth`` and ``poses`` where nothing is named.

        Raises:
            InputError: There is no such field.
            MissingPackageError: torch is not installed.
        """
        return torch_view(self, fields or ("rgb", "depth", "poses"))

    @checked
    def evaluate(
        self,
        estimator: str | Path | Callable[..., Any] | object,
        split: str | None = None,
        out: str | Path | None = None,
        bop: bool = False,
        vsd: bool = False,
        **settings: Any,
    ) -> "Scores":
        """Estimate the poses of a split and score them.

        Args:
            estimator: A name, a run folder, "file.py:Class", "module:Class", an object with ``estimate(image)``, or
                a function that takes an ``RgbdImage`` and returns a list of ``PoseEstimate``.
            split: A split or "all"; by default test, or all that is there where test is empty.
            out: Folder for predictions and scores, which ``ws.report`` takes; none by default.
            bop: Whether the scores of the BOP challenges are added.
            vsd: Whether these have the recall by VSD, too.
            settings: As ``ws.predict`` takes them, such as ``refine="icp"``.

        Returns:
            The scores: ``scores["overall"]["metrics"]["add_10pct"]``, as in ``scores.json``.
        """
        chosen = chosen_split(self, split)
        estimates = estimates_of(self, estimator, chosen, settings)
        return scores_of(self, estimates, chosen, out, bop, vsd, method_name(estimator))

    @property
    def scored(self) -> DatasetReader:
        """What the stages below read of it: its observations alone."""
        if self._chosen is None:
            return self._reader
        return self._reader.only((image.split, image.scene_id, image.image_id) for image in self._images)

    @cached_property
    def _all_images(self) -> list[ImageRecord]:
        images = [image for split in self._reader.parts for image in self._reader.images(split)]
        return sorted(images, key=lambda image: (image.scene_id, image.image_id))

    @cached_property
    def _images(self) -> list[ImageRecord]:
        return self._all_images if self._chosen is None else [self._all_images[place] for place in self._chosen]

    def _part(self, places: Sequence[int]) -> "Dataset":
        """Return a view of some observations by their places in this one."""
        chosen = range(len(self)) if self._chosen is None else self._chosen
        part = Dataset.__new__(Dataset)
        part.path, part._reader = self.path, self._reader
        part._chosen = tuple(chosen[place] for place in places)
        part.__dict__["_all_images"] = self._all_images
        return part

    def _count_by_split(self) -> dict[str, int]:
        counts = {name: sum(image.split == name for image in self._images) for name in self._reader.parts}
        return {name: count for name, count in counts.items() if count}


def as_dataset(data: "Dataset | str | Path") -> Dataset:
    """Return a dataset that is open, or open its folder."""
    return data if isinstance(data, Dataset) else Dataset(data)


def _whole(index: Any) -> int:
    try:
        if not isinstance(index, (bool, np.bool_)):
            return operator.index(index)
    except TypeError:
        pass
    raise InputError(f"a Dataset is indexed by a whole number or a slice, found {shown(index)}")


def _places(index: "slice[Any, Any, Any]", count: int) -> list[int]:
    try:
        return list(range(count))[index]
    except (TypeError, ValueError):
        raise InputError(f"a slice of a Dataset has whole numbers and no step of 0, found {shown(index)}") from None


def _reopened(path: str, chosen: tuple[int, ...] | None) -> Dataset:
    data = Dataset(path)
    data._chosen = chosen
    return data
