"""Checks of KITTI labels against scene records, images and depth; what leans has no label but is among DontCare."""

import itertools
import math

import numpy as np

from warehouse_sim.dataset.checks.depth import range_fraction
from warehouse_sim.dataset.checks.findings import Findings
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.files.image_io import decode_depth, image_size_wh
from warehouse_sim.dataset.formats.kitti.checks.frames import (
    LabelRow,
    T_world_image,
    file_of,
    frames,
    is_levelled,
    read_camera,
    read_labels,
    read_points,
)
from warehouse_sim.dataset.formats.kitti.reader import KittiLabel
from warehouse_sim.dataset.split import Split
from warehouse_sim.dataset.stored.scene_record import RecordedObject
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, invert, transform_points

_LEVELS = (0.9, 0.5)
"""Visible fractions of what lies in the image from which ``occluded`` is 0 and 1."""
_ROUNDING = 1e-4
"""Of ``truncated``, which has four digits."""
_CORNERS = np.array(list(itertools.product((-0.5, 0.5), repeat=3)))
_NEAR = 0.05
_BESIDE_PX = 2.0
_DAMAGED = 0.03
"""By so much (m) damaged objects stand out of their boxes."""
_FEW = 200
"""So few points on the depth image say nothing."""
_SAMPLE = 15_000
"""Points of a sweep that are looked at, about."""
_SAME_DEPTH = 0.1
"""Of a point and the depth beside it, as a fraction: more than half of them agree so well, edges and noise included."""
_STEPS_PER_METRE = 256.0


def shown(subject: Subject) -> Findings:
    """Hold truncation and occlusion against the scene record, and 2D boxes against the projected 3D boxes."""
    findings = Findings()
    for split, scene, observation, frame in frames(subject):
        where = str(file_of(subject, split, "label_2", frame))
        camera = read_camera(subject, split, frame)[0]
        noted = (
            {}
            if is_levelled(subject)
            else {
                item.instance_id: item.visible_fraction
                for item in subject.record(scene).observations[observation].targets
            }
        )
        for number, row in enumerate(read_labels(subject, split, frame), start=1):
            if row.label.is_dont_care:
                continue
            if row.instance_id in noted:
                _fractions_agree(findings, row, noted[row.instance_id], camera, f"{where}:{number}")
            _box_is_there(findings, row, camera, f"{where}:{number}")
            findings.count += 1
    findings.examined = f"{findings.count} labels on their images"
    return findings


def points_on_depth(subject: Subject) -> Findings:
    """Points of the LiDAR lie, through calib, where the depth image has them: along the axis and in metres."""
    numbers = [(split, frame) for split, _, _, frame in frames(subject)]
    findings = subject.put_together(numbers, lambda item: _points_agree(subject, *item))
    findings.examined = f"{findings.count} points on depth images"
    return findings


def _fractions_agree(findings: Findings, row: LabelRow, visible: float, camera: PinholeCamera, where: str) -> None:
    label = row.label
    left, top, right, bottom = label.box_xyxy
    at_border = left <= 0 or top <= 0 or right >= camera.width - 1 or bottom >= camera.height - 1
    inside = 1.0 - label.truncated
    findings.require(
        visible <= inside + _ROUNDING and (at_border or label.truncated == 0.0),
        f"{where}: truncated is {label.truncated}, but {visible:.4f} of it is visible"
        + ("" if at_border else " and its box ends within the image"),
    )
    # What lies in the image is known to four digits only.
    fractions = [visible / max(inside + step, 1e-9) for step in (_ROUNDING, -_ROUNDING)]
    levels = {next((i for i, least in enumerate(_LEVELS) if fraction >= least), 2) for fraction in fractions}
    findings.require(
        label.occluded in levels,
        f"{where}: occluded is {label.occluded}, {visible:.4f} of it is visible and {inside:.4f} in the image",
    )


def _box_is_there(findings: Findings, row: LabelRow, camera: PinholeCamera, where: str) -> None:
    """Require the 2D box within the projection of the 3D box, which holds all of the object."""
    height, breadth, length = row.label.size_hwl
    corners = transform_points(row.label.T_camera_object(), _CORNERS * [length, breadth, height])
    if corners[:, 2].min() < _NEAR or camera.distortion is not None:
        return
    uv = camera.project(corners)
    slack = _BESIDE_PX + _DAMAGED * camera.fx / corners[:, 2].min()
    last = np.array([camera.width - 1, camera.height - 1])
    low, high = np.clip(uv.min(axis=0), 0, last) - slack, np.clip(uv.max(axis=0), 0, last) + slack
    beyond = max(float((low - row.label.box_xyxy[:2]).max()), float((np.array(row.label.box_xyxy[2:]) - high).max()))
    findings.require(
        beyond <= 0, f"{where}: the 2D box leaves the projected 3D box by {beyond + slack:.1f} px; P2 or a box is wrong"
    )


def _points_agree(subject: Subject, split: Split, frame: int) -> Findings:
    findings = Findings()
    camera, T_camera_lidar = read_camera(subject, split, frame)
    path = file_of(subject, split, "depth_2", frame)
    depth = decode_depth(path).astype(np.float64) / _STEPS_PER_METRE
    cloud = read_points(subject, split, frame).points
    points = transform_points(T_camera_lidar, cloud[:: max(len(cloud) // _SAMPLE, 1)].astype(np.float64))
    points = points[points[:, 2] > _NEAR]
    u, v = np.rint(camera.project(points)).T
    inside = (u >= 0) & (v >= 0) & (u < depth.shape[1]) & (v < depth.shape[0])
    points, read = points[inside], depth[v[inside].astype(int), u[inside].astype(int)]
    points, read = points[read > 0], read[read > 0]
    findings.count = len(points)
    if len(points) < _FEW:
        return findings
    z, distance = points[:, 2], np.linalg.norm(points, axis=1)
    off = float(np.median(np.abs(read - z) / z))
    findings.require(
        off < _SAME_DEPTH,
        f"{path}: differs from the points of velodyne by {100 * off:.0f} % of the depth; its unit (1/256 m a step), "
        "the points or Tr_velo_to_cam are wrong",
    )
    fraction = range_fraction(read, z, distance)
    findings.require(
        fraction < 0.5, f"{path}: holds the distance to the camera, not the depth along its axis (share {fraction:.2f})"
    )
    return findings


_SAME_PLACE = 1e-5
_LARGEST_TILT = math.radians(2.0)
# Rounding on the way through files must not turn one that leans just so much into one that leans more.
_SAME_TILT = 1e-6


def labels(subject: Subject) -> Findings:
    """Every row parses strictly, has plausible values, and is that of its object in the scene record."""
    findings, count, leaning = Findings(), 0, 0
    for split, scene, observation, frame in frames(subject):
        path = file_of(subject, split, "label_2", frame)
        size_wh = image_size_wh(file_of(subject, split, "image_2", frame))
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
