"""What readers have in common: images by split, the size of their files, boxes for masks, what a folder lacks."""

from collections.abc import Iterable
from pathlib import Path, PurePosixPath
from typing import NoReturn

import numpy as np
from jaxtyping import Bool, Float32, UInt8

from warehouse_sim.dataset.files.image_io import decode_any_depth, decode_any_rgb
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.dataset.split import require_split
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.symmetry import SymmetryGroup

Box = tuple[float, float, float, float]
_LARGEST_BOX = 65_535


class ReaderBase:
    """Base of readers; without more there are no clean images.

    Args:
        root: Folder that the reader reads.
        splits: Names of its splits.
    """

    has_clean = False

    def __init__(self, root: Path, splits: Iterable[str]) -> None:
        self.root, self._names = root, tuple(splits)
        self._images: dict[str, list[ImageRecord]] = {}

    def images(self, split: str) -> list[ImageRecord]:
        """Return the images of a split, by scene and image id; they are read once.

        Raises:
            DatasetError: No such split, or a file is missing or malformed.
        """
        require_split(self.root, split, self._names)
        if split not in self._images:
            self._images[split] = self._read(split)
        return self._images[split]

    def clean_rgb(self, image: ImageRecord) -> np.ndarray:
        """Reject: only this package stores it."""
        raise DatasetError(f"{self.root}: holds no clean images")

    def clean_depth(self, image: ImageRecord) -> np.ndarray:
        """Reject: only this package stores it."""
        raise DatasetError(f"{self.root}: holds no clean images")

    def _read(self, split: str) -> list[ImageRecord]:
        raise NotImplementedError


class FileReader(ReaderBase):
    """Base of readers of third-party files, whatever their kind: one file for each image."""

    def rgb(self, image: ImageRecord) -> UInt8[np.ndarray, "h w 3"]:
        """Read the colour image; a grey one has three equal channels."""
        return require_size(decode_any_rgb(self._file(image, "rgb")), image, "rgb")

    def depth(self, image: ImageRecord) -> Float32[np.ndarray, "h w"]:
        """Read the depth image: metres along the optical axis, 0 = no reading."""
        return metres(decode_any_depth(self._file(image, "depth")), image)

    def mask_visible(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Read the mask of a target's visible pixels."""
        raise NotImplementedError

    def mask(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Read the same mask, where there is no other: what is hidden of a target nobody knows."""
        return self.mask_visible(image, gt_index)

    def _file(self, image: ImageRecord, kind: str) -> Path:
        """Return the file of an image, "rgb" or "depth"."""
        raise NotImplementedError


class ImagesOnly(FileReader):
    """Base of readers of formats that hold images with boxes and masks: no depth, no shapes."""

    has_depth = False

    def depth(self, image: ImageRecord) -> NoReturn:
        """Reject: there is none."""
        raise DatasetError(f"{self.root}: holds no depth images; read the dataset in a format that does, such as bop")


def metres(steps: np.ndarray, image: ImageRecord, kind: str = "depth") -> Float32[np.ndarray, "h w"]:
    """Return depth (m) of an image's file in its own steps, whose size must be the camera's."""
    return require_size(steps, image, kind).astype(np.float32) * np.float32(image.depth_scale / 1000.0)


def require_size(pixels: np.ndarray, image: ImageRecord, kind: str) -> np.ndarray:
    """Return ``pixels`` of an image's file.

    Raises:
        DatasetError: They are not as many as the camera's.
    """
    if pixels.shape[:2] != (image.camera.height, image.camera.width):
        raise DatasetError(
            f"{image.split} scene {image.scene_id}: {kind} of image {image.image_id} is {pixels.shape[:2]}, "
            f"the camera {(image.camera.height, image.camera.width)} (h, w)"
        )
    return pixels


def shapeless(number: int, name: str, root: Path) -> ObjectInfo:
    """Return what is known of a class without a CAD geometry: its name; size and diameter are 0."""
    return ObjectInfo(number, name, name, np.zeros(3), 0.0, SymmetryGroup.trivial(), (), root, is_scan=True)


def guessed_camera(width: int, height: int) -> PinholeCamera:
    """Return a camera of an image's size; its focal length, the larger edge (53 deg across), is only for drawing."""
    return PinholeCamera.from_focal(width, height, float(max(width, height)))


def box_mask(box_xyxy: Box, camera: PinholeCamera, halves_up: bool = False) -> Bool[np.ndarray, "h w"]:
    """Return the pixels of a box, which stands for a mask where there is none.

    Args:
        box_xyxy: Inclusive corners (px); may leave the image.
        camera: Of the image.
        halves_up: Whether corners between two pixels are the later one's, else the even one's.
    """
    mask = np.zeros((camera.height, camera.width), dtype=bool)
    bounded = np.clip(box_xyxy, -2, _LARGEST_BOX)
    left, top, right, bottom = (np.floor(bounded + 0.5) if halves_up else np.rint(bounded)).astype(int)
    mask[max(top, 0) : max(bottom + 1, 0), max(left, 0) : max(right + 1, 0)] = True
    return mask


def inside(folder: Path, name: str, where: str) -> Path:
    """Return the file of that name in a folder.

    Raises:
        DatasetError: The name leads out of it.
    """
    path = PurePosixPath(name)
    if not name or path.is_absolute() or ".." in path.parts or "\\" in name or "\0" in name:
        raise DatasetError(f"{where}: {name[:80]!r} must be the name of a file in the dataset, without '..'")
    return folder / path
