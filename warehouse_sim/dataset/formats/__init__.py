"""Dataset formats, one folder each: how observations are written, read and checked, and what a format cannot hold."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Protocol

import numpy as np
from jaxtyping import Bool, Float32, UInt8

from warehouse_sim.dataset.checks.findings import NamedCheck
from warehouse_sim.dataset.formats.observation_files import ObservationFiles
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.registry import Registry
from warehouse_sim.schema import ObjectModel, SceneSpec

FORMATS = Registry("dataset format")
FORMATS.add("bop", "warehouse_sim.dataset.formats.bop:FORMAT")
FORMATS.add("bop_compact", "warehouse_sim.dataset.formats.bop.shards:COMPACT_FORMAT")
FORMATS.add("bop_webdataset", "warehouse_sim.dataset.formats.bop.shards:FORMAT")
FORMATS.add("coco", "warehouse_sim.dataset.formats.coco:FORMAT")
FORMATS.add("folder", "warehouse_sim.dataset.formats.folder:FORMAT")
FORMATS.add("kitti", "warehouse_sim.dataset.formats.kitti:FORMAT")
FORMATS.add("linemod", "warehouse_sim.dataset.formats.linemod:FORMAT")
FORMATS.add("mcap", "warehouse_sim.dataset.formats.mcap:FORMAT")
FORMATS.add("pcd", "warehouse_sim.dataset.formats.clouds:PCD")
FORMATS.add("ply", "warehouse_sim.dataset.formats.clouds:PLY")
FORMATS.add("yolo", "warehouse_sim.dataset.formats.yolo:FORMAT")


class SceneWriter(Protocol):
    """Writes the observations of one scene, in order."""

    def write(self, files: ObservationFiles) -> None:
        """Store one observation.

        Raises:
            DatasetError: The format cannot hold it.
        """

    def finish(self) -> None:
        """Store what covers the whole scene."""


class DatasetWriter(Protocol):
    """Writes one format; built again in every process, so it holds nothing but where and what to write."""

    def begin(self, models: Sequence[ObjectModel], camera: PinholeCamera) -> None:
        """Store what all scenes share; called once, before any scene.

        Args:
            models: Every geometry that a label can name.
            camera: The rig's camera.
        """

    def scene(self, scene: SceneSpec) -> SceneWriter:
        """Open a settled scene, removing what an interrupted run left of it.

        Scenes are written in any order, by several processes at once: no file belongs to two scenes.
        """

    def finish(self) -> None:
        """Store what needs all scenes; called once, after the last scene."""


class FormatReader(Protocol):
    """Reads one format, as training and scoring need it.

    Two more methods may say more of an image: ``sweep(image)`` returns the main LiDAR's mounted sweep, None where there
    is none, and ``rgb_file(image)`` the file of its colour image, None where it is not 8-bit RGB as PNG. With the class
    attribute ``has_depth = False`` there are no depth images.
    """

    @property
    def objects(self) -> Mapping[int, ObjectInfo]:
        """The CAD geometries of the targets by obj_id."""

    @property
    def splits(self) -> Mapping[str, tuple[int, ...]]:
        """Scene numbers of each split."""

    @property
    def has_clean(self) -> bool:
        """Whether there are images without errors of a sensor beside those that were read."""

    def images(self, split: str) -> list[ImageRecord]:
        """Return the images of a split, by scene and image id.

        Raises:
            DatasetError: No such split, or a file is missing or malformed.
        """

    def files(self, split: str) -> list[Path]:
        """Return all files that the images and labels of a split are read from, sorted."""

    def rgb(self, image: ImageRecord) -> UInt8[np.ndarray, "h w 3"]:
        """Read the colour image."""

    def depth(self, image: ImageRecord) -> Float32[np.ndarray, "h w"]:
        """Read the depth image: metres along the optical axis, 0 = no reading."""

    def clean_rgb(self, image: ImageRecord) -> UInt8[np.ndarray, "h w 3"]:
        """Read the colour image without errors of a camera; requested only if ``has_clean``."""

    def clean_depth(self, image: ImageRecord) -> Float32[np.ndarray, "h w"]:
        """Read the depth without errors of a sensor (m); requested only if ``has_clean``."""

    def mask_visible(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Read the mask of a target's visible pixels."""

    def mask(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Read the mask of a target's whole amodal mask, as far as it lies in the image."""


class Format(Protocol):
    """A dataset format; its files go into the dataset's folder of its name.

    A method ``sweep(root, manifest, image)`` may read the main LiDAR's mounted sweep of an image of a dataset with a
    manifest, where the format holds them. Attributes may say more of it: with ``needs_level_camera = True``
    observations of a camera that can tilt have a second one in ``Observation.level``, that of a level virtual camera;
    with ``needs_meshes = True`` a mesh of every object is stored; ``needs`` and ``holds`` are the outputs
    (``schema.outputs``) that it cannot do without and has a place for, ``counts`` those that its labels are counted
    from, stored or not.
    """

    @property
    def name(self) -> str:
        """As in ``--formats``."""

    @property
    def checks(self) -> Sequence[NamedCheck]:
        """Checks of its files, in order."""

    def reject(self, manifest: Manifest) -> None:
        """Reject what the format cannot hold at all, before anything is made.

        Raises:
            DatasetError: Names the setting of the recipe that requires it.
        """

    def writer(self, root: Path, manifest: Manifest) -> DatasetWriter:
        """Return a writer into the dataset's folder; nothing is written yet."""

    def reader(self, root: Path) -> FormatReader | None:
        """Return a reader of the dataset's folder; None from a format that training and scoring cannot read.

        A folder without a manifest, made by others, is handed over only if the format ``recognises`` it.
        """

    def recognises(self, root: Path) -> bool:
        """Return whether a folder without a manifest holds files of this format."""


def needs_level_camera(item: Format) -> bool:
    """Return whether a format knows level cameras only; no if silent."""
    return bool(getattr(item, "needs_level_camera", False))


def needs_meshes(item: Format) -> bool:
    """Return whether a format stores a mesh of every object; no if silent."""
    return bool(getattr(item, "needs_meshes", False))


def has_depth(reader: FormatReader) -> bool:
    """Return whether a reader has depth images; yes if silent."""
    return bool(getattr(reader, "has_depth", True))


def third_party_checks(item: Format) -> Sequence[NamedCheck]:
    """Return the checks of third-party folders in a format, beyond those of every format.

    They take a ``ThirdPartySubject``. A format states them as the attribute ``third_party_checks``, or has none.
    """
    return tuple(getattr(item, "third_party_checks", ()))


def dataset_format(name: str) -> Format:
    """Return the format of that name.

    Raises:
        UnknownNameError: It is not registered.
    """
    found: Format = FORMATS.get(name)
    return found
