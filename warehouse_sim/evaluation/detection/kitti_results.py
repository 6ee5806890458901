"""Estimated poses as KITTI's result files: upright boxes of the mean size of their class."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from jaxtyping import Float

from warehouse_sim.dataset.formats.kitti.external import ExternalKittiReader, external_folder
from warehouse_sim.dataset.formats.kitti.reader import KittiLabel, label_line, upright_label
from warehouse_sim.dataset.reader import ALL
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.errors import EvaluationError
from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, invert, transform_points
from warehouse_sim.output import make_folder, write_bytes
from warehouse_sim.schema import PoseEstimate

_NEAREST = 0.1
"""Corners nearer to the camera's plane than this (m) have no place in the image; they are taken to be so far away."""


def write_kitti_results(estimates: Sequence[PoseEstimate], data: Path, split: str, folder: Path) -> None:
    """Write ``000000.txt`` ... of the frames of a split, 16 fields a row.

    KITTI has no CAD: an estimate is of a class, whose box is the mean of those labelled in train (in all splits, where
    train has none). The box stands upright with the estimate's centre and heading; its score is the estimate's. What
    lies behind the camera has no row.

    Args:
        estimates: Poses of the boxes' centre frames (x along the length, z up) in camera 2.
        data: A folder of KITTI's layout.
        split: Of the folder, or all.
        folder: Where to write; made if it is missing.

    Raises:
        EvaluationError: The folder is none of KITTI's, or an estimate is of another frame or class.
        OutputError: A file cannot be written.
    """
    root = external_folder(data)
    if root is None:
        raise EvaluationError(
            f"{data}: is not of KITTI's layout, training/calib ...; leave out --kitti, or name a dataset's folder kitti"
        )
    reader = ExternalKittiReader(root)
    parts = list(reader.splits) if split == ALL else [split]
    images = {image.scene_id: image for part in parts for image in reader.images(part)}
    sizes, rows = _mean_sizes(reader), dict[int, list[str]]({frame: [] for frame in images})
    for item in estimates:
        if item.scene_id not in rows:
            raise EvaluationError(f"an estimate is of frame {item.scene_id}, which is not in split {split!r}")
        if item.obj_id not in sizes:
            raise EvaluationError(f"an estimate is of object {item.obj_id}, a class without labelled boxes")
        name, size = sizes[item.obj_id]
        image = images[item.scene_id]
        if item.T_camera_object[2, 3] > _NEAREST:
            label = _label(name, size, item.T_camera_object, image, reader.T_camera_rect(image))
            rows[item.scene_id].append(f"{label_line(label)} {item.score:.6f}")
    make_folder(folder)
    for frame, lines in rows.items():
        write_bytes(folder / f"{frame:06d}.txt", "".join(f"{line}\n" for line in lines).encode())


def _mean_sizes(reader: ExternalKittiReader) -> dict[int, tuple[str, Float[np.ndarray, " 3"]]]:
    """Return name and mean box (length, width, height, m) of each class by its number."""
    found = {number: (info.name, info.size) for number, info in reader.objects.items()}
    labelled: dict[int, list[Float[np.ndarray, " 3"]]] = {}
    for image in reader.images("train"):
        for target in image.targets:
            if target.geometry is not None:
                labelled.setdefault(target.obj_id, []).append(target.geometry.size)
    return found | {number: (found[number][0], np.mean(sizes, axis=0)) for number, sizes in labelled.items()}


def _label(
    name: str,
    size: Float[np.ndarray, " 3"],
    T_camera_object: Transform,
    image: ImageRecord,
    T_camera_rect: Transform,
) -> KittiLabel:
    label = upright_label(name, size, invert(T_camera_rect) @ T_camera_object)
    return replace(label, box_xyxy=_box_in_image(T_camera_rect @ label.T_camera_object(), size, image.camera))


def _box_in_image(
    T_camera_box: Transform, size: Float[np.ndarray, " 3"], camera: PinholeCamera
) -> tuple[float, float, float, float]:
    """Return the edges of a box's corners in the image, cut at its border."""
    corners = transform_points(T_camera_box, box_corners(size))
    corners[:, 2] = np.maximum(corners[:, 2], _NEAREST)
    u, v = camera.project(corners).T
    last_u, last_v = camera.width - 1.0, camera.height - 1.0
    return (
        float(np.clip(u.min(), 0.0, last_u)),
        float(np.clip(v.min(), 0.0, last_v)),
        float(np.clip(u.max(), 0.0, last_u)),
        float(np.clip(v.max(), 0.0, last_v)),
    )
