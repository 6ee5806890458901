"""Checks of the BOP folder's files and tables."""

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from warehouse_sim.dataset.checks.findings import Findings, compare_names
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.files.json_file import read_json, read_table
from warehouse_sim.dataset.files.plain import take
from warehouse_sim.dataset.formats.bop.layout import bop_layout
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.dataset.split import SPLITS
from warehouse_sim.geometry.pose import invert

_TABLES = ("camera", "gt", "gt_info", "gt_coco")
_SAME_POSE = 1e-6
_SAME_FRACTION = 1e-9
# Visible fraction from which BOP asks for a target (calc_gt_info and the challenge's targets).
_VISIBLE_ENOUGH = 0.1


def files(subject: Subject) -> Findings:
    """Each split holds its scenes and no other; each scene its images, masks and tables and nothing else."""
    findings, count = Findings(), 0
    for split in SPLITS:
        scene_names = {f"{index:06d}" for index in subject.manifest.splits[split]}
        folder = bop_layout(subject.root).root / split
        if scene_names or folder.exists():
            compare_names(findings, folder, scene_names, "scene")
    images = {f"{index:06d}.png" for index in range(subject.manifest.observations_per_scene)}
    for split, scene in subject.scenes():
        layout = bop_layout(subject.root).scene(split, scene)
        tables = {f"scene_{name}.json" for name in _TABLES}
        channels = ("rgb", "depth", *(("rgb_clean", "depth_clean") if subject.readable.has_clean else ()))
        compare_names(findings, layout.root, {*channels, "mask", "mask_visib"} | tables)
        poses = read_table(layout.table("gt"))
        masks = {f"{image_id:06d}_{i:06d}.png" for image_id, row in poses.items() for i in range(_count(row))}
        for name, expected in (*((name, images) for name in channels), ("mask", masks), ("mask_visib", masks)):
            compare_names(findings, layout.root / name, expected)
            count += len(expected)
    findings.examined = f"{count} images and masks"
    return findings


def tables(subject: Subject) -> Findings:
    """Compare the tables with the scene records: the same images, objects, cameras and rigid poses."""
    findings, count = Findings(), 0
    wanted = set(range(subject.manifest.observations_per_scene))
    for split, scene in subject.scenes():
        path = bop_layout(subject.root).scene(split, scene).table("camera")
        listed = set(read_table(path))
        findings.require(listed == wanted, f"{path}: lists images {sorted(listed)}, the manifest {sorted(wanted)}")
    for image in subject.images():
        count += len(image.targets)
        _agrees_with_record(findings, subject, image)
    findings.examined = f"{count} poses, rigid and equal to the scene records"
    return findings


def coco(subject: Subject) -> Findings:
    """scene_gt_coco.json holds the same objects, areas and boxes as scene_gt and scene_gt_info, in the same order."""
    findings, count = Findings(), 0
    for split in SPLITS:
        by_scene: dict[int, list[ImageRecord]] = {}
        for image in subject.readable.images(split):
            by_scene.setdefault(image.scene_id, []).append(image)
        for scene, images in by_scene.items():
            path = bop_layout(subject.root).scene(split, scene).table("gt_coco")
            count += _coco_agrees(findings, path, images)
    findings.examined = f"{count} annotations"
    return findings


def targets(subject: Subject) -> Findings:
    """Compare the target files with what is visible enough in the test split."""
    findings = Findings()
    rows19, rows24 = [], []
    for image in subject.readable.images("test"):
        key = {"scene_id": image.scene_id, "im_id": image.image_id}
        counts = Counter(target.obj_id for target in image.targets if target.visible_fraction >= _VISIBLE_ENOUGH)
        rows19 += [{**key, "obj_id": obj_id, "inst_count": counts[obj_id]} for obj_id in sorted(counts)]
        rows24.append(key)
    for year, rows in ((2019, rows19), (2024, rows24)):
        path = bop_layout(subject.root).targets(year)
        findings.require(read_json(path) == rows, f"{path}: does not ask for what the test split shows")
    findings.examined = f"{len(rows19)} targets in {len(rows24)} test images"
    return findings


def _count(row: Any) -> int:
    """Return the number of poses of an image; what is no list is reported where it is read."""
    return len(row) if isinstance(row, list) else 0


def _agrees_with_record(findings: Findings, subject: Subject, image: ImageRecord) -> None:
    record = subject.record(image.scene_id)
    where = f"{bop_layout(subject.root).scene(image.split, image.scene_id).table('gt')}: {image.image_id}"
    if not findings.require(image.image_id < len(record.T_world_camera), f"{where}: is not in the scene record"):
        return
    measured = {item.instance_id: item for item in record.observations[image.image_id].targets}
    T_world_camera = record.T_world_camera[image.image_id]
    moved = np.abs(image.T_world_camera - T_world_camera).max()
    findings.require(bool(moved < _SAME_POSE), f"{where}: the camera is not where the scene record has it")
    for target in image.targets:
        item = record.object(target.instance_id)
        here = f"{where}[{target.gt_index}]"
        if not findings.require(item is not None, f"{here}: instance {target.instance_id} is not in the scene record"):
            continue
        assert item is not None
        known = target.obj_id in subject.objects and item.obj_id == target.obj_id
        findings.require(known, f"{here}: obj_id {target.obj_id} is unknown or not that of the scene record")
        moved = np.abs(target.T_camera_object - invert(T_world_camera) @ item.T_world_object).max()
        findings.require(bool(moved < _SAME_POSE), f"{here}: the pose differs from the scene record by {moved:.2e}")
        noted = measured.get(target.instance_id)
        if noted is not None:
            said = noted.visible_fraction, noted.pixels_all
            same = abs(said[0] - target.visible_fraction) < _SAME_FRACTION and said[1] == target.pixels_all
            findings.require(
                same,
                f"{here}: visib_fract {target.visible_fraction:.6g} of {target.pixels_all} px, "
                f"the scene record has {said[0]:.6g} of {said[1]}",
            )


def _coco_agrees(findings: Findings, path: Path, images: list[ImageRecord]) -> int:
    data, where = read_json(path), str(path)
    expected_images = [
        {
            "id": image.image_id,
            "file_name": f"rgb/{image.image_id:06d}.png",
            "width": image.camera.width,
            "height": image.camera.height,
        }
        for image in images
    ]
    findings.require(take(data, "images", list, where) == expected_images, f"{where}: images differ from scene_camera")
    annotations = take(data, "annotations", list, where)
    pairs = [(image, target) for image in images for target in image.targets]
    if not findings.require(
        len(annotations) == len(pairs), f"{where}: {len(annotations)} annotations, {len(pairs)} poses"
    ):
        return 0
    for i, (annotation, (image, target)) in enumerate(zip(annotations, pairs, strict=True)):
        left, top, right, bottom = target.box_amodal_xyxy
        expected = {
            "id": i + 1,
            "image_id": image.image_id,
            "category_id": target.obj_id,
            "area": target.pixels_visible,
            "bbox": [left, top, right - left + 1, bottom - top + 1],
            "ignore": target.visible_fraction < _VISIBLE_ENOUGH,
        }
        for key, value in expected.items():
            found = annotation.get(key) if isinstance(annotation, dict) else None
            findings.require(found == value, f"{where}: annotation {i + 1}: {key} is {found!r}, not {value!r}")
    return len(annotations)
