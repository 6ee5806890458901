"""The frames of a dataset: which there are, where their images and points are, and what their files hold."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float, Float32, Int32

from warehouse_sim.dataset.checks.findings import Findings, read_text
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.files.extent import read_bytes
from warehouse_sim.dataset.files.image_io import image_size_wh
from warehouse_sim.dataset.formats.bop import NAME
from warehouse_sim.dataset.formats.kitti import NAME as FORMAT_NAME
from warehouse_sim.dataset.formats.kitti import frames_of, kitti_layout
from warehouse_sim.dataset.formats.kitti.reader import KittiLabel, calib_camera, parse_calib, parse_label
from warehouse_sim.dataset.split import Split
from warehouse_sim.dataset.stored.observation_record import RecordedObservation
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.level_view import levelled
from warehouse_sim.geometry.pose import Transform, invert, make_transform, transform_points

_LARGEST_LEAN = np.deg2rad(2.0) + 1e-6
_SAME_PLACE = 1e-5


_ID = re.compile("[0-9]{1,10}")


def as_measured(
    points: Float[np.ndarray, "n 3"], T_world_points: Transform, observation: RecordedObservation
) -> Float[np.ndarray, "n 3"]:
    """Return stored points (m) in the frame of the LiDAR itself."""
    if observation.T_camera_lidar is None:
        return points
    T_lidar_points = invert(observation.T_world_camera @ observation.T_camera_lidar) @ T_world_points
    return transform_points(T_lidar_points, points.astype(float))


def is_level(findings: Findings, T_world_points: Transform, observation: RecordedObservation, where: str) -> None:
    """Require that z is up in the frame of stored points, and that it is where the LiDAR is, if that leans."""
    leaning = float(np.arccos(np.clip(T_world_points[2, 2], -1.0, 1.0)))
    findings.require(
        leaning <= _LARGEST_LEAN, f"{where}: the z axis of the points leans by {np.rad2deg(leaning):.2f} deg"
    )
    if observation.T_camera_lidar is not None:
        T_world_lidar = observation.T_world_camera @ observation.T_camera_lidar
        apart = float(np.abs(T_world_lidar[:3, 3] - T_world_points[:3, 3]).max())
        findings.require(apart < _SAME_PLACE, f"{where}: the LiDAR of the scene record is {apart:.6f} m from there")


OTHER = NAME
"""With its files in the dataset, too, both must agree, and images need not be decoded twice."""


def file_of(subject: Subject, split: str, kind: str, frame: int) -> Path:
    """Return a file of a frame."""
    return kitti_layout(subject.root).file(split, kind, frame)


def frames(subject: Subject) -> Iterator[tuple[Split, int, int, int]]:
    """Yield split, scene, observation and frame number of every observation."""
    for split, scene, observation in subject.observations():
        yield split, scene, observation, frames_of(subject.manifest, scene)[observation]


def T_world_image(subject: Subject, scene: int, observation: int) -> Transform:
    """Return where the camera of a frame's image is: that of the scene record, or the level one in its place."""
    T_world_camera = subject.T_world_camera(scene, observation)
    return levelled(T_world_camera) if is_levelled(subject) else T_world_camera


def is_levelled(subject: Subject) -> bool:
    """Return whether frames are those of a level virtual camera in the place of a tilted one."""
    return FORMAT_NAME in subject.manifest.contents.levelled


@dataclass(frozen=True)
class LabelRow:
    """A row of a label file, and whose it is."""

    label: KittiLabel
    instance_id: int


def read_labels(subject: Subject, split: str, frame: int) -> list[LabelRow]:
    """Read a frame's rows and ids, those of DontCare included; the one row of a frame without labels is left out.

    Raises:
        DatasetError: A file is missing, empty, has a blank line, or a row that does not parse.
    """
    path, ids_path = (file_of(subject, split, kind, frame) for kind in ("label_2", "label_2_ids"))
    lines, ids = read_text(path).split("\n"), read_text(ids_path).split("\n")
    if len(lines) < 2 or lines[-1]:
        raise DatasetError(f"{path}: at least one row and a line end after the last one are expected")
    found = [parse_label(line, f"{path}:{number}") for number, line in enumerate(lines[:-1], start=1)]
    if len(ids) != len(lines) or ids[-1] or not all(_ID.fullmatch(word) for word in ids[:-1]):
        raise DatasetError(f"{ids_path}: does not hold an instance id for each of the {len(found)} rows of label_2")
    cares = [not label.is_dont_care for label in found]
    if cares != sorted(cares, reverse=True):
        raise DatasetError(f"{path}: DontCare must come last")
    rows = [LabelRow(label, int(word)) for label, word in zip(found, ids, strict=False)]
    return [] if len(rows) == 1 and not cares[0] and rows[0].instance_id == 0 else rows


def read_points(
    subject: Subject, split: Split, frame: int, name: str = "velodyne"
) -> tuple[Float32[np.ndarray, "n 4"], Int32[np.ndarray, " n"]]:
    """Read a sweep, of the LiDAR whose folder is ``name``, and the instance id of each point.

    Raises:
        DatasetError: A file is missing or the two have not the same number of points.
    """
    path, ids_path = (file_of(subject, split, kind, frame) for kind in (name, f"{name}_ids"))
    cloud, ids = read_bytes(path), read_bytes(ids_path)
    if len(cloud) % 16 or len(cloud) != 4 * len(ids):
        raise DatasetError(f"{path}: {len(cloud)} bytes of points do not go with {len(ids)} bytes of ids")
    return np.frombuffer(cloud, dtype="<f4").reshape(-1, 4), np.frombuffer(ids, dtype="<i4")


def read_camera(subject: Subject, split: str, frame: int) -> tuple[PinholeCamera, Transform]:
    """Read the calib file of a frame: its camera, and T_camera_lidar of the points that are stored."""
    path = file_of(subject, split, "calib", frame)
    matrices = parse_calib(read_text(path), str(path))
    size_wh = image_size_wh(file_of(subject, split, "image_2", frame))
    matrix = matrices["Tr_velo_to_cam"]
    return calib_camera(matrices, size_wh), make_transform(matrix[:, :3], matrix[:, 3])
