"""One scene of a BOP folder that others made."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from warehouse_sim.dataset.formats.bop.tables import DEPTH_SCALES, read_box, read_camera
from warehouse_sim.dataset.image_io import decode_any_mask, image_size_wh
from warehouse_sim.dataset.json_file import read_table
from warehouse_sim.dataset.plain import PLACES, SHARES, WHOLE, Span, take, take_if_given, take_numbers
from warehouse_sim.dataset.records import ImageRecord, TargetRecord
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.boxes import mask_box_xyxy
from warehouse_sim.geometry.pose import Transform, invert, make_transform

TABLE = "scene_{}.json"
_IMAGES = ("rgb", "gray")
_LARGEST_SKEW = 1e-2
"""How far a stored rotation may be from one: others round their numbers."""
_PLACES_MM = Span(1000.0 * PLACES.low, 1000.0 * PLACES.high)


@dataclass(frozen=True)
class ExternalScene:
    """Paths and tables of a scene."""

    root: Path
    scene_id: int

    def file(self, kind: str, image_id: int) -> Path:
        """Return the file of an image, whatever it ends with.

        Raises:
            DatasetError: There is none.
        """
        found = sorted((self.root / kind).glob(f"{image_id:06d}.*"))
        if not found:
            raise DatasetError(f"{self.root / kind}: there is no image {image_id}; training and scoring need it")
        return found[0]

    def image_file(self, image_id: int) -> Path:
        """Return the file of the colour or grey image.

        Raises:
            DatasetError: There is none.
        """
        kind = next((name for name in _IMAGES if (self.root / name).is_dir()), _IMAGES[0])
        return self.file(kind, image_id)

    def find_mask(self, kind: str, image_id: int, gt_index: int) -> Path | None:
        """Return the file of a mask, if there is one."""
        return next(iter(sorted((self.root / kind).glob(f"{image_id:06d}_{gt_index:06d}.*"))), None)

    def images(self, split: str) -> list[ImageRecord]:
        """Read the tables; images without labels have no targets.

        Raises:
            DatasetError: A table is malformed, or neither it nor a mask says where a target is in its image.
        """
        cameras = read_table(self._table("camera"))
        poses, infos = (
            read_table(self._table(name)) if self._table(name).is_file() else {} for name in ("gt", "gt_info")
        )
        size_wh = image_size_wh(self.image_file(min(cameras))) if cameras else (1, 1)
        return [self._image(split, key, cameras[key], poses, infos, size_wh) for key in cameras]

    def _table(self, name: str) -> Path:
        return self.root / TABLE.format(name)

    def _image(
        self, split: str, key: int, camera: Any, poses: dict, infos: dict, size_wh: tuple[int, int]
    ) -> ImageRecord:
        where = f"{self._table('camera')}: {key}"
        placed = isinstance(camera, dict) and "cam_R_w2c" in camera
        T_camera_world = read_rounded_pose(camera, "cam_R_w2c", "cam_t_w2c", where) if placed else np.eye(4)
        rows = take({"labels": poses.get(key, [])}, "labels", list, f"{self._table('gt')}: {key}")
        details = infos.get(key) or [{}] * len(rows)
        if len(details) != len(rows):
            raise DatasetError(f"{self.root}: scene_gt and scene_gt_info list other objects of image {key}")
        return ImageRecord(
            split=split,
            scene_id=self.scene_id,
            image_id=key,
            camera=read_camera(camera, size_wh, where),
            T_world_camera=invert(T_camera_world),
            depth_scale=take_if_given(camera, "depth_scale", float, where, DEPTH_SCALES) or 1.0,
            targets=tuple(self._target(key, i, row, details[i]) for i, row in enumerate(rows)),
        )

    def _target(self, image_id: int, index: int, pose: Any, info: Any) -> TargetRecord:
        where = f"{self._table('gt')}: {image_id}[{index}]"
        visible, whole = (self._box(kind, key, image_id, index, info, where) for kind, key in _BOXES)
        seen, whole = visible or whole, whole or visible
        if seen is None or whole is None:
            raise DatasetError(
                f"{where}: neither bbox_visib or bbox_obj in {TABLE.format('gt_info')} nor a file in mask_visib or "
                "mask says where the target is in its image; make them with bop_toolkit's calc_gt_masks, calc_gt_info"
            )
        seen_pixels = take_if_given(info, "px_count_visib", int, where, WHOLE)
        all_pixels = take_if_given(info, "px_count_all", int, where, WHOLE)
        seen_pixels = self._pixels("mask_visib", image_id, index, seen) if seen_pixels is None else seen_pixels
        all_pixels = max(self._pixels("mask", image_id, index, whole), 1) if all_pixels is None else all_pixels
        share = take_if_given(info, "visib_fract", float, where, SHARES)
        valid = take_if_given(info, "px_count_valid", int, where, WHOLE)
        return TargetRecord(
            gt_index=index,
            obj_id=take(pose, "obj_id", int, where, WHOLE),
            instance_id=0,
            T_camera_object=read_rounded_pose(pose, "cam_R_m2c", "cam_t_m2c", where),
            visible_fraction=min(seen_pixels / max(all_pixels, 1), 1.0) if share is None else share,
            pixels_visible=seen_pixels,
            box_visible_xyxy=seen,
            box_amodal_xyxy=whole,
            pixels_valid=seen_pixels if valid is None else valid,
            pixels_all=all_pixels,
        )

    def _box(
        self, kind: str, key: str, image_id: int, index: int, info: Any, where: str
    ) -> tuple[float, float, float, float] | None:
        """Return a box from the table, else that of the mask, if there is either."""
        if take_if_given(info, key, list, where) is not None:
            return read_box(info, key, where)
        path = self.find_mask(kind, image_id, index)
        box = None if path is None else mask_box_xyxy(decode_any_mask(path))
        return None if box is None else (float(box[0]), float(box[1]), float(box[2]), float(box[3]))

    def _pixels(self, kind: str, image_id: int, index: int, box: tuple[float, float, float, float]) -> int:
        path = self.find_mask(kind, image_id, index)
        if path is not None:
            return int(np.count_nonzero(decode_any_mask(path)))
        left, top, right, bottom = box
        return max(int(right - left + 1), 0) * max(int(bottom - top + 1), 0)


_BOXES = (("mask_visib", "bbox_visib"), ("mask", "bbox_obj"))


def read_rounded_pose(data: Any, rotation: str, translation: str, where: str) -> Transform:
    """Read a pose in millimetres; a rotation whose numbers were rounded becomes the nearest one.

    Raises:
        DatasetError: It is missing, or far from any rotation.
    """
    R = take_numbers(data, rotation, 9, where).reshape(3, 3)
    U, _, Vt = np.linalg.svd(np.clip(R, -2.0, 2.0))
    nearest = U @ Vt
    if np.linalg.det(nearest) < 0 or np.abs(nearest - R).max() > _LARGEST_SKEW:
        raise DatasetError(f"{where}: {rotation} is not a rotation: {R.ravel().tolist()}")
    return make_transform(nearest, take_numbers(data, translation, 3, where, _PLACES_MM) / 1000.0)
