"""The frames of a dataset: which there are, where their images and points are, and what their files hold."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float

from warehouse_sim.dataset.checks.findings import Findings, read_text
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.formats.bop import NAME
from warehouse_sim.dataset.formats.kitti import NAME as FORMAT_NAME
from warehouse_sim.dataset.formats.kitti import frames_of, kitti_layout
from warehouse_sim.dataset.formats.kitti.external_frame import KittiFrame, StoredSweep, read_sweep
from warehouse_sim.dataset.formats.kitti.reader import KittiLabel
from warehouse_sim.dataset.split import Split
from warehouse_sim.dataset.stored.observation_record import RecordedObservation
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.level_view import levelled
from warehouse_sim.geometry.pose import Transform, invert, transform_points

_LARGEST_LEAN = np.deg2rad(2.0) + 1e-6
_SAME_PLACE = 1e-5
_LEVEL = re.compile("-?[0-9]+")


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


def frame_of(subject: Subject, split: str, frame: int) -> KittiFrame:
    """Return the files of a frame."""
    return KittiFrame(kitti_layout(subject.root).folder(split), f"{frame:06d}")


def read_labels(subject: Subject, split: str, frame: int) -> list[LabelRow]:
    """Read a frame's rows and ids, those of DontCare included; the one row of a frame without labels is left out.

    Raises:
        DatasetError: A file is missing, empty, has a blank line, or a row that the strictest readers reject.
    """
    path = file_of(subject, split, "label_2", frame)
    *lines, end = read_text(path).split("\n")
    fields = [line.split(" ") for line in lines]
    if not lines or end or any(len(words) != 15 or not _LEVEL.fullmatch(words[2]) for words in fields):
        raise DatasetError(f"{path}: rows of 15 fields with single blanks are expected, the third a whole number")
    rows = [LabelRow(label, number) for number, label in frame_of(subject, split, frame).rows()]
    cares = [not row.label.is_dont_care for row in rows]
    if cares != sorted(cares, reverse=True):
        raise DatasetError(f"{path}: DontCare must come last")
    return [] if len(rows) == 1 and not cares[0] and rows[0].instance_id == 0 else rows


def read_points(subject: Subject, split: Split, frame: int, name: str = "velodyne") -> StoredSweep:
    """Read the sweep of the LiDAR whose folder is ``name``, with the instance id of each point.

    Raises:
        DatasetError: A file is missing, or two have not the same number of points.
    """
    sweep = read_sweep(frame_of(subject, split, frame), name)
    if sweep is None or sweep.instance_ids is None or (name == "velodyne" and sweep.beams is None):
        raise DatasetError(f"{file_of(subject, split, name, frame)}: points, their ids or their beams are missing")
    return sweep


def read_camera(subject: Subject, split: str, frame: int) -> tuple[PinholeCamera, Transform]:
    """Read the calib file of a frame: its camera, and T_camera_lidar of the points that are stored."""
    found = frame_of(subject, split, frame).calibration()
    if found.T_camera_lidar is None:
        raise DatasetError(f"{file_of(subject, split, 'calib', frame)}: has no line Tr_velo_to_cam")
    return found.camera, found.T_camera_lidar
