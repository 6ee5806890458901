"""Read a bare folder: colour, depth, intrinsics and masks, without poses and objects; all of it is the split "test"."""

from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool

from warehouse_sim.dataset.files.image_io import decode_any_mask, image_size_wh
from warehouse_sim.dataset.files.json_file import read_json
from warehouse_sim.dataset.files.plain import Span, decimal, read_transform, take, take_if_given, take_numbers
from warehouse_sim.dataset.files.png import is_rgb_png
from warehouse_sim.dataset.formats.folder import Frame, frames_of, intrinsics_file
from warehouse_sim.dataset.formats.reader_base import FileReader, require_size, shapeless
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.records import NO_POSE, ImageRecord, TargetRecord
from warehouse_sim.errors import DatasetError, shown
from warehouse_sim.geometry.boxes import mask_box_xyxy
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, invert

_KEYS = ("fx", "fy", "cx", "cy")
_PIXELS = Span(-1e6, 1e6)
_SCALES = Span(1e-3, 1e3)
_MOST_BYTES = 10_000
_PLACES = ("cam2root", "cam2world", "T_world_camera")
"""Files, and keys in them, of the camera's pose in the world (4 x 4, m)."""


class Intrinsics(NamedTuple):
    """What a file says of the camera."""

    fx: float
    fy: float
    cx: float
    cy: float
    size_wh: tuple[int, int] | None
    depth_scale: float
    """Millimetres a step of the depth images."""

    def camera(self, size_wh: tuple[int, int], where: str) -> PinholeCamera:
        """Return the camera of images of a size.

        Raises:
            DatasetError: The file is of another size, or of no camera.
        """
        if self.size_wh is not None and self.size_wh != size_wh:
            raise DatasetError(f"{where}: is of images of {self.size_wh}, the image is {size_wh} (w, h)")
        try:
            return PinholeCamera(*size_wh, self.fx, self.fy, self.cx, self.cy)
        except ValueError as problem:
            raise DatasetError(f"{where}: is no camera ({problem})") from problem


def read_intrinsics(path: Path) -> Intrinsics:
    """Read intrinsics: fx, fy, cx, cy, or a matrix under K, cam_K or camera_matrix; or a matrix as plain numbers.

    ``depth_scale`` is in millimetres a step, 1 by default.

    Raises:
        DatasetError: The file cannot be read, or holds no intrinsics.
    """
    where = str(path)
    if path.suffix == ".txt":
        return _of_matrix({"K": _numbers(path)}, "K", where, {})
    data = read_json(path)
    if isinstance(data, dict):
        key = next((key for key in ("K", "cam_K", "camera_matrix", "intrinsic_matrix") if key in data), None)
        if key is not None:
            return _of_matrix(data, key, where, data)
    fx, fy, cx, cy = (take(data, key, float, where, _PIXELS) for key in _KEYS)
    return Intrinsics(fx, fy, cx, cy, *_more(data, where))


def read_place(root: Path) -> Transform:
    """Return where the camera stood (m), the identity where no file says it.

    Raises:
        DatasetError: A file says it in another form than 4 x 4.
    """
    path = next((path for name in _PLACES if (path := root / f"{name}.json").is_file()), None)
    if path is None:
        return np.eye(4)
    data = read_json(path)
    key = next((key for key in _PLACES if isinstance(data, dict) and key in data), None)
    T = read_transform(data if key is None else data[key], str(path))
    # In the recordings that have it, it leads from the root to the camera: only so is their floor level, to 0.2 deg.
    return invert(T) if path.stem == "cam2root" else T


def _of_matrix(data: Any, key: str, where: str, more: Any) -> Intrinsics:
    rows = data[key]
    if isinstance(rows, list) and any(isinstance(row, list) for row in rows):
        data = {key: [value for row in rows if isinstance(row, list) for value in row]}
    fx, skew, cx, zero, fy, cy, *last = (float(value) for value in take_numbers(data, key, 9, where, _PIXELS))
    if skew != 0.0 or zero != 0.0 or last != [0.0, 0.0, 1.0]:
        raise DatasetError(f"{where}: {key} must be a pinhole camera without skew, row by row, found {shown(rows)}")
    return Intrinsics(fx, fy, cx, cy, *_more(more, where))


def _more(data: Any, where: str) -> tuple[tuple[int, int] | None, float]:
    width, height = (take_if_given(data, key, int, where) for key in ("width", "height"))
    scale = take_if_given(data, "depth_scale", float, where, _SCALES)
    return None if width is None or height is None else (width, height), 1.0 if scale is None else scale


def _numbers(path: Path) -> list[float]:
    try:
        if path.stat().st_size > _MOST_BYTES:
            raise DatasetError(f"{path}: is no matrix of nine numbers")
        return [decimal(word) for word in path.read_text(encoding="ascii").replace(",", " ").split()]
    except (OSError, ValueError) as problem:
        raise DatasetError(f"{path}: is no matrix of nine numbers ({problem})") from problem


_NUMBER, CLASS_NAME = 1, "object"
"""Of the one class."""


class FolderReader(FileReader):
    """A folder of images.

    Args:
        root: The folder.
    """

    def __init__(self, root: Path) -> None:
        super().__init__(root, ("test",))
        self.splits: dict[str, tuple[int, ...]] = {"test": (0,)}

    @property
    def objects(self) -> dict[int, ObjectInfo]:
        """One class without a shape: nobody says what is seen."""
        return {_NUMBER: shapeless(_NUMBER, CLASS_NAME, self.root)}

    def files(self, split: str) -> list[Path]:
        """Return all files of the images, sorted."""
        path = intrinsics_file(self.root)
        images = [file for frame in self._frames for file in (frame.rgb, frame.depth, *frame.masks)]
        return sorted([*images, *([] if path is None else [path])])

    def rgb_file(self, image: ImageRecord) -> Path | None:
        """Return the file of the colour image where it is an 8-bit RGB image in PNG."""
        path = self._file(image, "rgb")
        return path if is_rgb_png(path) else None

    def mask_visible(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Read the mask of a target."""
        return require_size(decode_any_mask(self._frames[image.image_id].masks[gt_index]), image, "mask")

    def mask(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Read the mask of a target: what is hidden of it nobody knows."""
        return self.mask_visible(image, gt_index)

    def _file(self, image: ImageRecord, kind: str) -> Path:
        frame = self._frames[image.image_id]
        return frame.rgb if kind == "rgb" else frame.depth

    @cached_property
    def _frames(self) -> list[Frame]:
        return frames_of(self.root)

    def _read(self, split: str) -> list[ImageRecord]:
        """Return the images; each has a target without a pose for every mask."""
        path = intrinsics_file(self.root)
        if path is None:
            raise DatasetError(f"{self.root}: says nothing of the camera; add intrinsics.json with fx, fy, cx, cy")
        intrinsics, T_world_camera = read_intrinsics(path), read_place(self.root)
        return [
            ImageRecord(
                split="test",
                scene_id=0,
                image_id=index,
                camera=intrinsics.camera(image_size_wh(frame.rgb), str(path)),
                T_world_camera=T_world_camera,
                depth_scale=intrinsics.depth_scale,
                targets=tuple(_target(number, path) for number, path in enumerate(frame.masks)),
            )
            for index, frame in enumerate(self._frames)
        ]


def _target(number: int, path: Path) -> TargetRecord:
    mask = decode_any_mask(path)
    left, top, right, bottom = (float(value) for value in mask_box_xyxy(mask) or (0, 0, -1, -1))
    pixels = int(np.count_nonzero(mask))
    return TargetRecord(
        gt_index=number,
        obj_id=_NUMBER,
        instance_id=0,
        T_camera_object=NO_POSE,
        visible_fraction=1.0 if pixels else 0.0,
        pixels_visible=pixels,
        box_visible_xyxy=(left, top, right, bottom),
        box_amodal_xyxy=(left, top, right, bottom),
        pixels_valid=pixels,
        pixels_all=max(pixels, 1),
    )
