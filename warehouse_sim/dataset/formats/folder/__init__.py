"""A bare folder of colour, depth, intrinsics and masks, as anybody's camera leaves it; read, never written."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

from warehouse_sim.dataset.checks.findings import NamedCheck
from warehouse_sim.dataset.formats import FormatReader
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.errors import DatasetError

_IMAGE = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp")
_WORDS = {"mask": ("mask", "segment"), "depth": ("depth",), "rgb": ("color", "colour", "rgb", "image", "img")}
"""Kind -> words that say so in the name of a file or of its folder; the first kind that fits is taken."""
_NUMBER = re.compile(r"\d+")


@dataclass(frozen=True)
class Frame:
    """The files of one image."""

    rgb: Path
    depth: Path
    masks: tuple[Path, ...]


def frames_of(root: Path) -> list[Frame]:
    """Return the images of a folder: files in it, or in folders such as rgb, depth and masks, one level deep.

    Colour and depth belong together in order of their names. A single image has all masks; of several images, those
    masks whose name begins with the same number as the colour image's.

    Raises:
        DatasetError: Colour and depth do not go together.
    """
    found = _by_kind(root)
    colours, depths = found["rgb"], found["depth"]
    if not colours or len(colours) != len(depths):
        raise DatasetError(
            f"{root}: holds {len(colours)} colour images (color*, rgb*) and {len(depths)} depth images (depth*); "
            "there must be a depth image for each colour image"
        )
    if len(colours) == 1:
        return [Frame(colours[0], depths[0], tuple(found["mask"]))]
    numbers = [_number(path) for path in colours]
    if numbers != [_number(path) for path in depths] or len(set(numbers)) < len(numbers) or None in numbers:
        raise DatasetError(f"{root}: colour and depth images must have the same numbers, each once, in their names")
    return [
        Frame(colour, depth, tuple(path for path in found["mask"] if _number(path) == number))
        for number, colour, depth in zip(numbers, colours, depths, strict=True)
    ]


def looks_like(root: Path) -> bool:
    """Return whether a folder holds colour images, depth images and a file of intrinsics."""
    if not root.is_dir() or intrinsics_file(root) is None:
        return False
    found = _by_kind(root)
    return bool(found["rgb"]) and bool(found["depth"])


def require_intrinsics(root: Path) -> None:
    """Require intrinsics where there are colour and depth images and nothing says what the camera is.

    Raises:
        DatasetError: That is so.
    """
    if not root.is_dir() or intrinsics_file(root) is not None:
        return
    found = _by_kind(root)
    if found["rgb"] and found["depth"]:
        raise DatasetError(
            f"{root}: holds colour and depth images, but nothing says what the camera is; put intrinsics.json with "
            "fx, fy, cx and cy (px) beside them"
        )


def intrinsics_file(root: Path) -> Path | None:
    """Return the file that says what the camera is, if there is one."""
    names = ("intrinsics.json", "camera.json", "camera_intrinsics.json", "K.txt", "intrinsics.txt", "cam_K.txt")
    return next((root / name for name in names if (root / name).is_file()), None)


def _by_kind(root: Path) -> dict[str, list[Path]]:
    """Return the images of a folder and of the folders in it by what they are, sorted by number, then by name."""
    found: dict[str, list[Path]] = {kind: [] for kind in _WORDS}
    for path in sorted(root.iterdir()):
        for file in sorted(path.iterdir()) if path.is_dir() else [path]:
            if file.suffix.lower() not in _IMAGE or not file.is_file():
                continue
            kind = _kind(file.stem) or (_kind(path.name) if path.is_dir() else None)
            if kind is not None:
                found[kind].append(file)
    return {kind: sorted(files, key=_order) for kind, files in found.items()}


def _kind(name: str) -> str | None:
    return next((kind for kind, words in _WORDS.items() if any(word in name.lower() for word in words)), None)


def _number(path: Path) -> int | None:
    match = _NUMBER.search(path.stem)
    return None if match is None or len(match[0]) > 9 else int(match[0])


def _order(path: Path) -> tuple[list[int], str]:
    return [int(text) for text in _NUMBER.findall(path.stem) if len(text) < 10], path.name


NAME = "folder"


class FolderFormat:
    """Images without poses: to look at and to predict on."""

    name = NAME
    checks: Sequence[NamedCheck] = ()
    needs = holds = ()

    def reject(self, manifest: Manifest) -> NoReturn:
        """Reject to be written: it has no place for labels."""
        raise DatasetError(f"{NAME}: bare folders are read only, they have no place for labels; choose another format")

    def writer(self, root: Path, manifest: Manifest) -> NoReturn:
        """Reject, as ``reject`` does."""
        self.reject(manifest)

    def reader(self, root: Path) -> FormatReader | None:
        """Return a reader of a third-party folder."""
        from warehouse_sim.dataset.formats.folder.reader import FolderReader

        return None if DatasetLayout(root).manifest.is_file() else FolderReader(root)

    def recognises(self, root: Path) -> bool:
        """Return whether the folder holds colour and depth images and intrinsics."""
        return looks_like(root)


FORMAT = FolderFormat()
