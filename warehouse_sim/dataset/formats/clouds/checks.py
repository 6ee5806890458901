"""Checks of clouds, held against the scene record, the grid of the pixels and the objects' boxes."""

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from warehouse_sim.dataset.checks.findings import Findings, NamedCheck, compare_names
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.files.json_file import read_json
from warehouse_sim.dataset.files.plain import WHOLE, read_transform, take
from warehouse_sim.dataset.files.point_table import CAMERA_FIELDS, SWEEP_FIELDS, Table, places
from warehouse_sim.dataset.files.record import read_camera_row
from warehouse_sim.dataset.formats.clouds import READERS, CloudLayout, cloud_layout
from warehouse_sim.dataset.split import Split
from warehouse_sim.dataset.stored.scene_record import RecordedObject
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, invert, transform_points
from warehouse_sim.schema import CAMERA
from warehouse_sim.schema.classes import class_number

_SAME_POSE = 1e-6
_OFF_GRID = 0.02
"""Pixels that a camera's point may lie beside a pixel's centre: rounding of its coordinates, with a margin."""
_OFF_BOX = 0.5
_OFF_FRACTION = 0.1
"""Median distance of an object's points from its box (m) that errors of sensors do not reach; wrong units do."""
_ENOUGH = 20
Place = tuple[Split, int, int]


def checks_of(name: str) -> Sequence[NamedCheck]:
    """Return the checks of the format of that name."""
    return (
        NamedCheck(f"{name} files", partial(files, name=name)),
        NamedCheck(f"{name} clouds", partial(clouds, name=name)),
    )


def files(subject: Subject, name: str) -> Findings:
    """Each scene's folder holds the clouds that the descriptions name and nothing else."""
    findings, layout = Findings(), cloud_layout(subject.root, name)
    scenes: dict[tuple[Split, int], set[str]] = {}
    for split, scene, observation in subject.observations():
        path = layout.description(split, scene, observation)
        sensors = take(read_json(path), "sensors", dict, str(path))
        names = scenes.setdefault((split, scene), set())
        names |= {path.name, *(layout.cloud(split, scene, observation, sensor).name for sensor in sensors)}
    for (split, scene), names in scenes.items():
        compare_names(findings, layout.scene(split, scene), names)
    findings.examined = f"{len(scenes)} scenes, {sum(map(len, scenes.values()))} files"
    return findings


def clouds(subject: Subject, name: str) -> Findings:
    """Clouds have the fields, numbers of points, poses, ids and classes of their observation, and are in metres."""
    layout = cloud_layout(subject.root, name)
    findings = subject.put_together(list(subject.observations()), partial(_observation, subject, layout))
    findings.examined = f"{findings.count} clouds: points, poses, ids, metres"
    return findings


def _observation(subject: Subject, layout: CloudLayout, place: Place) -> Findings:
    findings, (split, scene, observation) = Findings(), place
    path = layout.description(split, scene, observation)
    data, where = read_json(path), str(path)
    record, T_world_camera = subject.record(scene), read_transform(take(data, "T_world_camera", list, where), where)
    same = np.allclose(T_world_camera, subject.T_world_camera(scene, observation), rtol=0, atol=_SAME_POSE)
    findings.require(same, f"{path}: T_world_camera is not that of the scene record")
    objects = {item.instance_id: item for item in record.objects}
    sensors = take(data, "sensors", dict, where)
    for sensor, row in sensors.items():
        cloud = layout.cloud(split, scene, observation, sensor)
        table = READERS[layout.ending](cloud)
        T_camera_sensor = read_transform(take(row, "T_camera_sensor", list, where), f"{where}: {sensor}")
        expected = CAMERA_FIELDS if sensor == CAMERA else SWEEP_FIELDS
        if not findings.require(table.dtype == expected, f"{cloud}: fields are {table.dtype.descr}"):
            continue
        points = take(row, "points", int, where, WHOLE)
        findings.require(len(table) == points, f"{cloud}: holds {len(table)} points, {path.name} says {points}")
        finite = bool(np.isfinite(places(table)).all())
        if findings.require(finite, f"{cloud}: a coordinate is no number"):
            _ids(findings, table, objects, cloud)
            _boxes(subject, findings, table, T_world_camera @ T_camera_sensor, objects, cloud)
            if sensor == CAMERA:
                _grid(findings, table, read_camera_row(take(data, "camera", dict, where), f"{where}: camera"), cloud)
        findings.count += 1
    return findings


def _ids(findings: Findings, table: Table, objects: Mapping[int, RecordedObject], path: Path) -> None:
    for number in np.unique(table["instance_id"]).tolist():
        label = class_number(objects[number].class_name) if number in objects else 0
        found = np.unique(table["label"][table["instance_id"] == number]).tolist()
        findings.require(number == 0 or number in objects, f"{path}: instance {number} is not in the scene record")
        findings.require(found == [label], f"{path}: instance {number} has the labels {found}, expected {label}")


def _grid(findings: Findings, table: Table, camera: PinholeCamera, path: Path) -> None:
    """Note points of the camera that are not on the ray of a pixel of their own."""
    points = places(table)
    if not findings.require(bool((points[:, 2] > 0).all()), f"{path}: a point is behind the camera") or not len(points):
        return
    pixels = camera.project(points)
    off = float(np.abs(pixels - np.rint(pixels)).max())
    findings.require(off < _OFF_GRID, f"{path}: a point lies {off:.3f} px beside the centre of a pixel")
    column, line = np.rint(pixels).T
    inside = (column.min() >= 0) & (line.min() >= 0) & (column.max() < camera.width) & (line.max() < camera.height)
    flat = line * camera.width + column
    findings.require(bool(inside & (np.diff(flat) > 0).all()), f"{path}: points are not those of the pixels in order")


def _boxes(
    subject: Subject,
    findings: Findings,
    table: Table,
    T_world_sensor: Transform,
    objects: Mapping[int, RecordedObject],
    path: Path,
) -> None:
    """Note clouds in which most objects of known size have most of their points beside their boxes.

    A single object may: seen as slivers, a depth camera reads what lies behind it.
    """
    offs = []
    for number, item in objects.items():
        chosen = table[table["instance_id"] == number]
        if len(chosen) < _ENOUGH or item.obj_id not in subject.objects:
            continue
        local = transform_points(invert(item.T_world_object) @ T_world_sensor, places(chosen))
        outside = np.maximum(np.abs(local) - subject.info(item.obj_id).size / 2.0, 0.0)
        far = float(np.linalg.norm((invert(T_world_sensor) @ item.T_world_object)[:3, 3]))
        # Stereo errs by tenths of its distance where that is large.
        offs.append(float(np.median(np.linalg.norm(outside, axis=1))) - _OFF_FRACTION * far)
    off = float(np.median(offs)) if offs else 0.0
    findings.require(off < _OFF_BOX, f"{path}: points of objects lie {off:.3f} m off their boxes; metres are expected")
