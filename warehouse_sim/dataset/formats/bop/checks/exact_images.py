"""Checks of images of exact data: normals, object coordinates and class masks against labels and each other."""

import numpy as np

from warehouse_sim.dataset.checks.findings import Findings
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.formats.bop.layout import bop_layout
from warehouse_sim.dataset.formats.bop.reader import BopReader
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.geometry.pose import transform_points

_AWAY = 0.02
"""How far a normal may point away from the camera: a face seen along itself, its step and the pixel's size."""
_FROM_BEHIND = 1e-4
"""Fraction of pixels whose face may be seen from behind: rays beside edges, through a lens, pass cracks of meshes."""
_SHIFT_PX = 1.0
_BESIDE = 0.01
"""Fraction of pixels whose coordinates may be off: those of damaged objects that leave their boxes."""


def exact_images(subject: Subject) -> Findings:
    """Hold normals against rays, object coordinates, placed, against their pixels, classes against those of targets."""
    findings = subject.put_together(list(subject.images()), lambda image: _of_image(subject, image))
    findings.examined = f"{findings.count} images"
    return findings


def _of_image(subject: Subject, image: ImageRecord) -> Findings:
    findings, reader, contents = Findings(), subject.readable, subject.manifest.contents
    assert isinstance(reader, BopReader)
    layout = bop_layout(subject.root).scene(image.split, image.scene_id)
    seen = None
    if "class_mask" in contents.codings:
        seen = reader.class_mask(image) > 0
        _classes(findings, subject, reader, image, str(layout.image("class_mask", image.image_id)))
        findings.count += 1
    if "normals" in contents.codings:
        where, normals = str(layout.image("normals", image.image_id)), reader.normals(image)
        there = normals.any(axis=2)
        rays = image.camera.rays()
        towards = np.einsum("hwi,hwi->hw", rays, normals) / np.linalg.norm(rays, axis=2)
        away = np.count_nonzero(towards[there] > _AWAY)
        findings.require(
            bool(away <= _FROM_BEHIND * there.size), f"{where}: holds normals that face away from the camera"
        )
        findings.require(bool(there.any()), f"{where}: holds nothing but zeros")
        same = seen is None or np.array_equal(there, seen)
        findings.require(same, f"{where}: has normals elsewhere than class_mask has classes")
        findings.count += 1
    if "object_coordinates" in contents.codings:
        _coordinates(findings, subject, reader, image, str(layout.image("object_coordinates", image.image_id)))
        findings.count += 1
    return findings


def _classes(findings: Findings, subject: Subject, reader: BopReader, image: ImageRecord, where: str) -> None:
    values, names = reader.class_mask(image), reader.mask_classes(image)
    recorded = {item.class_name for item in subject.record(image.scene_id).objects}
    findings.require(set(names.values()) == recorded, f"{where}: its table names other classes than the scene record")
    if "masks" not in subject.manifest.contents.outputs:
        return
    for target in image.targets:
        shown = np.unique(values[reader.mask_visible(image, target.gt_index)]).tolist()
        wanted = subject.objects[target.obj_id].class_name
        same = [names.get(value) for value in shown] == [wanted]
        findings.require(same, f"{where}: target {target.gt_index} is {wanted}, its pixels are not")


def _coordinates(findings: Findings, subject: Subject, reader: BopReader, image: ImageRecord, where: str) -> None:
    coordinates = reader.object_coordinates(image)
    there = np.isfinite(coordinates).all(axis=2)
    count = sum(target.pixels_visible for target in image.targets)
    findings.require(
        np.count_nonzero(there) == count, f"{where}: holds {np.count_nonzero(there)} pixels, targets {count}"
    )
    if "masks" not in subject.manifest.contents.outputs:
        return
    v, u = np.indices(there.shape)
    for target in image.targets:
        shown = reader.mask_visible(image, target.gt_index)
        if not findings.require(bool(there[shown].all()), f"{where}: target {target.gt_index} has pixels without any"):
            continue
        in_object = (coordinates[shown].astype(float) - 0.5) * subject.objects[target.obj_id].size
        landed = image.camera.project(transform_points(target.T_camera_object, in_object))
        off = np.abs(landed - np.stack([u[shown], v[shown]], axis=1)).max(axis=1) > _SHIFT_PX
        # What is cut off at the box's faces is a whole face of what bulges: only what lies inside is held to it.
        inside = ((coordinates[shown] > 0.0) & (coordinates[shown] < 1.0)).all(axis=1)
        findings.require(
            bool(np.count_nonzero(off & inside) <= _BESIDE * len(off)),
            f"{where}: target {target.gt_index}: lies elsewhere",
        )
