"""Read a dataset folder, whatever its format: images, poses and masks of a split, objects and their meshes."""

import hashlib
from collections.abc import Iterable, Mapping
from copy import copy
from dataclasses import replace
from functools import cached_property
from itertools import chain
from pathlib import Path
from typing import Any, Literal

import numpy as np
from jaxtyping import Bool, Float32, UInt8, UInt16

from warehouse_sim.dataset.formats import FORMATS, FormatReader, dataset_format, has_depth
from warehouse_sim.dataset.formats.folder import require_intrinsics
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.manifest import Manifest, read_manifest, require_no_part
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.records import ImageRecord, TargetRecord
from warehouse_sim.dataset.split import parts_of
from warehouse_sim.dataset.stored.readings import read_reading
from warehouse_sim.dataset.stored.scene_record import read_scene_record
from warehouse_sim.errors import DatasetError
from warehouse_sim.schema import ChannelReading, LidarScan, MountedReading, NominalCalibration
from warehouse_sim.schema.outputs import Output

__all__ = [
    "ALL",
    "Calibration",
    "DatasetReader",
    "ImageRecord",
    "ObjectInfo",
    "TargetRecord",
    "is_dataset",
    "open_format",
]


Calibration = Literal["true", "nominal"]
"""The calibration that images and labels were made by, or what the rig says that it is."""
Place = tuple[str, int, int]
"""Split, scene id and image id."""
ALL = "all"
"""Stands for all splits where one is named."""


class DatasetReader:
    """A complete dataset in a format that can be read, or a folder in such a format made by third parties.

    A dataset that holds only KITTI or YOLO, which are read without a manifest, is read as a third-party one from the
    folder of that format, which is then the reader's ``root``.

    Args:
        root: Folder of the dataset.
        calibration: Whether cameras, depth as it is read and poses of sensors are true, or as the rig states them;
            pixels, masks, labels and clean images are always those of the ground truth.

    Raises:
        DatasetError: The folder is no complete dataset, or has none of the formats that can be read.
    """

    def __init__(self, root: str | Path, calibration: Calibration = "true") -> None:
        self.calibration: Calibration = calibration
        self._only: frozenset[Place] | None = None
        self._nominal: dict[int, tuple[NominalCalibration, ...]] = {}
        self.root, manifest, self._reader = _opened(Path(root))
        self.manifest: Manifest | None = manifest
        """What the dataset is; None of a third-party dataset."""

    @property
    def name(self) -> str:
        """Name of the recipe that it was made from, or of the folder."""
        return self.root.resolve().name if self.manifest is None else self.manifest.contents.name or "unnamed"

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the manifest, by which scores and runs find the dataset again; else of third-party labels."""
        if self.manifest is not None:
            return hashlib.sha256(DatasetLayout(self.root).manifest.read_bytes()).hexdigest()
        digest = hashlib.sha256()
        for path in (path for split in self.splits for path in self._reader.files(split)):
            digest.update(f"{path.relative_to(self.root)} {path.stat().st_size}\n".encode())
            digest.update(path.read_bytes() if path.suffix in (".json", ".txt") else b"")
        return digest.hexdigest()

    @property
    def objects(self) -> Mapping[int, ObjectInfo]:
        """The CAD geometries of the targets by obj_id."""
        return self._reader.objects

    @property
    def splits(self) -> Mapping[str, tuple[int, ...]]:
        """Scene numbers of each split."""
        return self._reader.splits

    @property
    def parts(self) -> tuple[str, ...]:
        """The splits, each image in one of them: see ``parts_of``."""
        return parts_of(self.splits)

    @property
    def has_clean(self) -> bool:
        """Whether there are clean images beside those that were read."""
        return self._reader.has_clean

    @property
    def has_depth(self) -> bool:
        """Whether there are depth images."""
        return has_depth(self._reader)

    def leaves_out(self, output: Output) -> bool:
        """Return whether the dataset was made without an output that others of its kind hold; no of third parties."""
        return self.manifest is not None and output in self.manifest.contents.left_out

    def images(self, split: str) -> list[ImageRecord]:
        """Return the images of a split, or of all of them (``ALL``), by scene and image id.

        Raises:
            DatasetError: No such split, a table is missing or malformed, or no calibration is stated.
        """
        images = self._all_images() if self._is_all(split) else self._reader.images(split)
        if self._only is not None:
            images = [image for image in images if (image.split, image.scene_id, image.image_id) in self._only]
        if self.calibration == "true":
            return images
        return [replace(image, camera=self._nominal_at(image).camera) for image in images]

    def calibrated(self, calibration: Calibration) -> "DatasetReader":
        """Return a reader of the same images with another calibration."""
        reader = copy(self)
        reader.calibration = calibration
        return reader

    def only(self, places: Iterable[Place]) -> "DatasetReader":
        """Return a reader of the same dataset that sees some of its images."""
        reader = copy(self)
        reader._only = frozenset(places)
        return reader

    def files(self, split: str) -> list[Path]:
        """Return all files that the images and labels of a split are read from, sorted."""
        if not self._is_all(split):
            return self._reader.files(split)
        return sorted({path for name in self.parts for path in self._reader.files(name)})

    def rgb(self, image: ImageRecord) -> UInt8[np.ndarray, "h w 3"]:
        """Read the colour image."""
        return self._reader.rgb(image)

    def depth(self, image: ImageRecord) -> Float32[np.ndarray, "h w"]:
        """Read the depth image: metres along the optical axis, 0 = no reading."""
        depth = self._reader.depth(image)
        return depth if self.calibration == "true" else depth * np.float32(self._nominal_at(image).depth_factor)

    def clean_rgb(self, image: ImageRecord) -> UInt8[np.ndarray, "h w 3"]:
        """Read the colour image as it was drawn, without errors of a camera.

        Raises:
            DatasetError: The dataset was made without clean images.
        """
        self._require_clean()
        return self._reader.clean_rgb(image)

    def clean_depth(self, image: ImageRecord) -> Float32[np.ndarray, "h w"]:
        """Read the depth without errors of a sensor: metres, 0 = nothing there, or farther than the file can say.

        Raises:
            DatasetError: The dataset was made without clean images.
        """
        self._require_clean()
        return self._reader.clean_depth(image)

    def mask_visible(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Read the mask of a target's visible pixels."""
        return self._reader.mask_visible(image, gt_index)

    def mask(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Read the mask of a target's whole amodal mask, as far as it lies in the image."""
        return self._reader.mask(image, gt_index)

    def normals(self, image: ImageRecord) -> Float32[np.ndarray, "h w 3"]:
        """Read the unit normals of surfaces in the camera frame, zeros where there is nothing.

        Raises:
            DatasetError: The dataset was made without them.
        """
        found: Float32[np.ndarray, "h w 3"] = self._exact("normals").normals(image)
        return found

    def object_coordinates(self, image: ImageRecord) -> Float32[np.ndarray, "h w 3"]:
        """Read where visible target pixels lie in the boxes of their objects: 0-1 along each edge, NaN elsewhere.

        Raises:
            DatasetError: The dataset was made without them.
        """
        found: Float32[np.ndarray, "h w 3"] = self._exact("object_coordinates").object_coordinates(image)
        return found

    def class_mask(self, image: ImageRecord) -> UInt16[np.ndarray, "h w"]:
        """Read which class each pixel shows, as a value of ``mask_classes``; 0 = nothing.

        Raises:
            DatasetError: The dataset was made without class masks.
        """
        found: UInt16[np.ndarray, "h w"] = self._exact("class_mask").class_mask(image)
        return found

    def mask_classes(self, image: ImageRecord) -> dict[int, str]:
        """Return the class that each value of an image's class mask stands for; it may differ between scenes."""
        found: dict[int, str] = self._exact("class_mask").mask_classes(image)
        return found

    def sweep(self, image: ImageRecord) -> MountedReading[LidarScan] | None:
        """Read the sweep of the main LiDAR; None where no format of the dataset holds one.

        Raises:
            DatasetError: A file is missing or malformed.
        """
        if self.manifest is None:
            read = getattr(self._reader, "sweep", None)
            return None if read is None else read(image)
        for name in (name for name in self.manifest.formats if name in FORMATS.names()):
            read = getattr(dataset_format(name), "sweep", None)
            if read is not None:
                found: MountedReading[LidarScan] = read(self.root, self.manifest, image)
                return found
        return None

    def rgb_file(self, image: ImageRecord) -> Path | None:
        """Return the file of the colour image, if it is an 8-bit RGB image in PNG."""
        read = getattr(self._reader, "rgb_file", None)
        return None if read is None else read(image)

    def readings(self, image: ImageRecord) -> dict[str, MountedReading[ChannelReading]]:
        """Read what other sensors than cameras and LiDARs gave at the observation, by their names in the rig.

        Raises:
            DatasetError: A file is missing, or is not what the manifest says.
        """
        sensors = {} if self.manifest is None else self.manifest.contents.readings
        layout = DatasetLayout(self.root)
        found = {
            name: read_reading(layout.reading(name, image.scene_id, image.image_id), contents)
            for name, contents in sensors.items()
        }
        places = {} if self.calibration == "true" else self._nominal_at(image).T_camera_sensor
        return {
            name: MountedReading(places.get(name, item.T_camera_sensor), item.reading) for name, item in found.items()
        }

    def _exact(self, output: Output) -> Any:
        """Return the reader of images of exact data.

        Raises:
            DatasetError: They were left out, or third parties made the dataset.
        """
        if self.manifest is None:
            raise DatasetError(f"{self.root}: holds no {output}, which only generate makes; see its --outputs")
        self.manifest.contents.require(output, self.root)
        return self._exact_reader

    @cached_property
    def _exact_reader(self) -> FormatReader | None:
        """The reader of a format that holds images of exact data; None where none does."""
        names = () if self.manifest is None else self.manifest.formats
        others = (dataset_format(name).reader(self.root) for name in names if name in FORMATS.names())
        return next((item for item in chain([self._reader], others) if hasattr(item, "normals")), None)

    def _is_all(self, split: str) -> bool:
        return split == ALL and ALL not in self.splits

    def _all_images(self) -> list[ImageRecord]:
        images = [image for split in self.parts for image in self._reader.images(split)]
        return sorted(images, key=lambda image: (image.scene_id, image.image_id))

    def _nominal_at(self, image: ImageRecord) -> NominalCalibration:
        """Return what the rig states of its calibration at an image.

        Raises:
            DatasetError: It states nothing.
        """
        if image.scene_id not in self._nominal:
            record = None if self.manifest is None else read_scene_record(self.root, image.scene_id)
            found = [item.nominal for item in record.observations] if record else [None]
            given = tuple(item for item in found if item is not None)
            if len(given) < len(found):
                raise DatasetError(
                    f"{self.root}: holds no nominal calibration; generate it with sensors.calibration: {{}}, "
                    "or read it with the true one"
                )
            self._nominal[image.scene_id] = given
        return self._nominal[image.scene_id][image.image_id]

    def _require_clean(self) -> None:
        if not self.has_clean:
            raise DatasetError(f"{self.root}: holds no clean images; generate it with --outputs default clean")


def is_dataset(root: str | Path) -> bool:
    """Return whether a folder holds a complete dataset, or one made by third parties."""
    root = Path(root)
    return DatasetLayout(root).manifest.is_file() or _external(root) is not None


def _opened(root: Path) -> tuple[Path, Manifest | None, FormatReader]:
    """Return the folder that is read, the manifest if it has one, and its reader.

    Raises:
        DatasetError: The folder is no complete dataset, or has none of the formats that can be read.
    """
    found = _external(root)
    if found is not None:
        return root, None, found
    manifest = read_manifest(root)
    found = open_format(root, manifest.formats)
    if found is not None:
        return root, manifest, found
    inner = {root / name: reader for name in manifest.formats if (reader := _external(root / name)) is not None}
    if not inner:
        raise DatasetError(
            f"{root}: was made without a format that training and scoring read; "
            f"generate it with one of them under --formats: {', '.join(_readable(root))}"
        )
    folder = max(inner, key=lambda path: has_depth(inner[path]))
    return folder, None, inner[folder]


def open_format(root: Path, names: Iterable[str]) -> FormatReader | None:
    """Return a reader of the first of these formats that has one, of one with depth if there is any; None if not."""
    known = FORMATS.names()
    readers = [dataset_format(name).reader(root) for name in names if name in known]
    found = [reader for reader in readers if reader is not None]
    # Depth is what most of the package needs.
    return next(iter(sorted(found, key=lambda reader: not has_depth(reader))), None)


def _external(root: Path) -> FormatReader | None:
    """Return a reader of a folder that a known format recognises, though nothing in it is of a dataset of this package.

    What has no manifest but the rest of a dataset is none of others: it is incomplete, as ``read_manifest`` says.

    Raises:
        DatasetError: It is a format's folder of an incomplete dataset.
    """
    layout = DatasetLayout(root)
    if any(path.exists() for path in (layout.manifest, layout.unfinished, layout.objects, layout.scenes)):
        return None
    require_no_part(root)
    found = open_format(root, [name for name in FORMATS.names() if dataset_format(name).recognises(root)])
    if found is None:
        require_intrinsics(root)
    return found


def _readable(root: Path) -> list[str]:
    readers = {name: dataset_format(name).reader(root) for name in FORMATS.names()}
    return [name for name, reader in readers.items() if reader is not None and has_depth(reader)]
