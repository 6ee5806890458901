"""What readers have in common of formats that hold images with boxes and masks: no depth, no shapes."""

from pathlib import Path, PurePosixPath
from typing import NoReturn

import numpy as np
from jaxtyping import Bool

from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.symmetry import SymmetryGroup

Box = tuple[float, float, float, float]


class ImagesOnly:
    """Base of readers without depth.

    Args:
        root: Folder that the reader reads.
    """

    has_clean = False
    has_depth = False

    def __init__(self, root: Path) -> None:
        self.root = root

    def depth(self, image: ImageRecord) -> NoReturn:
        """Reject: there is none."""
        raise DatasetError(f"{self.root}: holds no depth images; read the dataset in a format that does, such as bop")

    def clean_rgb(self, image: ImageRecord) -> NoReturn:
        """Reject: there is none."""
        raise DatasetError(f"{self.root}: holds no clean images")

    def clean_depth(self, image: ImageRecord) -> NoReturn:
        """Reject: there is none."""
        raise DatasetError(f"{self.root}: holds no clean images")


def shapeless(number: int, name: str, root: Path) -> ObjectInfo:
    """Return what is known of a class without a CAD geometry: its name; size and diameter are 0."""
    return ObjectInfo(number, name, name, np.zeros(3), 0.0, SymmetryGroup.trivial(), (), root, is_scan=True)


def guessed_camera(width: int, height: int) -> PinholeCamera:
    """Return a camera of an image's size; its focal length, the larger edge (53 deg across), is only for drawing."""
    return PinholeCamera.from_focal(width, height, float(max(width, height)))


def box_mask(box_xyxy: Box, camera: PinholeCamera) -> Bool[np.ndarray, "h w"]:
    """Return the pixels of a box of inclusive corners, which stands for a mask where there is none."""
    mask = np.zeros((camera.height, camera.width), dtype=bool)
    left, top, right, bottom = np.floor(np.clip(box_xyxy, -1, 65_536) + 0.5).astype(int)
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
