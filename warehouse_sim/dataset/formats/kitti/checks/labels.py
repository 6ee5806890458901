"""Checks of KITTI labels against the scene records; what leans has no label but a place among DontCare."""

import math
import re
from dataclasses import dataclass

import numpy as np

from warehouse_sim.dataset.checks.findings import Findings, read_text
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.files.image_io import png_size_wh
from warehouse_sim.dataset.formats.kitti.checks.frames import T_world_image, frames
from warehouse_sim.dataset.formats.kitti.label import KittiLabel
from warehouse_sim.dataset.formats.kitti.layout import kitti_layout
from warehouse_sim.dataset.formats.kitti.reader import parse_label
from warehouse_sim.dataset.stored.scene_record import RecordedObject
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.pose import Transform, invert

_ID = re.compile("[0-9]{1,10}")
_SAME_PLACE = 1e-5
_LARGEST_TILT = math.radians(2.0)
# Rounding on the way through files must not turn one that leans just so much into one that leans more.
_SAME_TILT = 1e-6


@dataclass(frozen=True)
class LabelRow:
    """A row of a label file, and whose it is."""

    label: KittiLabel
    instance_id: int


def labels(subject: Subject) -> Findings:
    """Every row parses strictly, has plausible values, and is that of its object in the scene record."""
    findings, count, leaning = Findings(), 0, 0
    for split, scene, observation, frame in frames(subject):
        path = kitti_layout(subject.root).file(split, "label_2", frame)
        size_wh = png_size_wh(kitti_layout(subject.root).file(split, "image_2", frame))
        T_camera_world = invert(T_world_image(subject, scene, observation))
        for number, row in enumerate(read_labels(subject, split, frame), start=1):
            where = f"{path}:{number}"
            _box_in_image(findings, row.label, size_wh, where)
            item = subject.record(scene).object(row.instance_id)
            if not findings.require(item is not None, f"{where}: the scene record has no object {row.instance_id}"):
                continue
            assert item is not None
            T_camera_object = T_camera_world @ item.T_world_object
            if row.label.is_dont_care:
                _is_leaning_target(findings, subject, item, T_camera_object, where)
                leaning += 1
            else:
                _is_recorded(findings, subject, row.label, item, T_camera_object, where)
            count += 1
    findings.examined = f"{count} labels of 15 fields" + (f", {leaning} of them DontCare: they lean" if leaning else "")
    return findings


def read_labels(subject: Subject, split: str, frame: int) -> list[LabelRow]:
    """Read a frame's rows and ids, those of DontCare included; the one row of a frame without labels is left out.

    Raises:
        DatasetError: A file is missing, empty, has a blank line, or a row that does not parse.
    """
    path, ids_path = (kitti_layout(subject.root).file(split, kind, frame) for kind in ("label_2", "label_2_ids"))
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


def tilt(T_camera_object: Transform) -> float:
    """Return by how much an object leans against a level camera's vertical (rad)."""
    return float(np.arctan2(np.linalg.norm(T_camera_object[[0, 2], 2]), -T_camera_object[1, 2]))


def is_tilted(T_camera_object: Transform) -> bool:
    """Return whether an object leans too much for an upright box."""
    return tilt(T_camera_object) > _LARGEST_TILT - _SAME_TILT


def is_upright(T_camera_object: Transform) -> bool:
    """Return whether an object leans little enough for an upright box."""
    return tilt(T_camera_object) < _LARGEST_TILT + _SAME_TILT


def _is_leaning_target(
    findings: Findings, subject: Subject, item: RecordedObject, T_camera_object: Transform, where: str
) -> None:
    findings.require(
        item.class_name in subject.manifest.targets,
        f"{where}: object {item.instance_id} is a {item.class_name}, which is no target",
    )
    lean = math.degrees(tilt(T_camera_object))
    findings.require(
        is_tilted(T_camera_object), f"{where}: object {item.instance_id} leans by {lean:.2f} deg only, but is DontCare"
    )


def _is_recorded(
    findings: Findings,
    subject: Subject,
    label: KittiLabel,
    item: RecordedObject,
    T_camera_object: Transform,
    where: str,
) -> None:
    moved = float(np.abs(label.T_camera_object()[:3, 3] - T_camera_object[:3, 3]).max())
    same = item.class_name == label.type and moved < _SAME_PLACE
    findings.require(same, f"{where}: is no {label.type} where the scene record has object {item.instance_id}")
    turned = math.remainder(label.rotation_y - math.atan2(-T_camera_object[2, 0], T_camera_object[0, 0]), 2 * math.pi)
    findings.require(
        abs(turned) < _SAME_PLACE, f"{where}: rotation_y is {turned:.6f} rad off that of object {item.instance_id}"
    )
    lean = math.degrees(tilt(T_camera_object))
    findings.require(
        is_upright(T_camera_object), f"{where}: object {item.instance_id} leans by {lean:.2f} deg and must be DontCare"
    )
    length, breadth, height = subject.info(item.obj_id).size
    same_size = np.abs(np.subtract(label.size_hwl, (height, breadth, length))).max() < _SAME_PLACE
    findings.require(bool(same_size), f"{where}: size {label.size_hwl} is not that of object {item.obj_id}")
    findings.require(0.0 <= label.truncated <= 1.0, f"{where}: truncated {label.truncated} is not in 0-1")
    findings.require(label.occluded in (0, 1, 2), f"{where}: occluded {label.occluded} is not 0, 1 or 2")
    x, _, z = label.location
    turn = label.rotation_y - math.atan2(x, z) - label.alpha
    findings.require(
        abs(math.remainder(turn, 2 * math.pi)) < _SAME_PLACE and max(abs(label.alpha), abs(label.rotation_y)) <= 3.1416,
        f"{where}: alpha {label.alpha} and rotation_y {label.rotation_y} do not go together",
    )


def _box_in_image(findings: Findings, label: KittiLabel, size_wh: tuple[int, int], where: str) -> None:
    left, top, right, bottom = label.box_xyxy
    findings.require(
        0 <= left <= right <= size_wh[0] - 1 and 0 <= top <= bottom <= size_wh[1] - 1,
        f"{where}: the 2D box {label.box_xyxy} is not in the image of {size_wh[0]} x {size_wh[1]}",
    )
