"""Checks of COCO files; masks are decoded by pycocotools."""

from typing import Any

import numpy as np
from jaxtyping import Bool
from pycocotools import mask as coco_mask

from warehouse_sim.dataset.checks.findings import Findings, NamedCheck, compare_names
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.files.image_io import decode_mask, decode_rgb
from warehouse_sim.dataset.files.json_file import read_json
from warehouse_sim.dataset.files.plain import take, take_numbers
from warehouse_sim.dataset.files.run_lengths import mask_of_runs
from warehouse_sim.dataset.formats.coco.layout import TABLES, coco_layout, image_name
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.dataset.split import SPLITS
from warehouse_sim.geometry.pose import invert

_SAME_POSE = 1e-6
# Visible fraction below which a target is a region to ignore.
_VISIBLE_ENOUGH = 0.1


def files(subject: Subject) -> Findings:
    """Each split holds the images of its observations, the images of their segments, three tables, and no more."""
    findings, layout = Findings(), coco_layout(subject.root)
    folders = {f"panoptic_{split}" for split in SPLITS}
    compare_names(findings, layout.annotations, {f"{n}_{s}.json" for n in TABLES for s in SPLITS} | folders)
    for split in SPLITS:
        found = [(scene, index) for name, scene, index in subject.observations() if name == split]
        names = {f"{image_name(scene, index)}.png" for scene, index in found}
        compare_names(findings, layout.images(split), names)
        compare_names(findings, layout.segments(split), names)
        findings.count += 2 * len(names)
    findings.examined = f"{findings.count} images"
    return findings


def instances(subject: Subject) -> Findings:
    """Compare annotations with the scene records, and areas and boxes with the masks; no two masks overlap."""
    findings, numbers = Findings(), set()
    for split in SPLITS:
        tables = [_by_image(subject, name, split) for name in ("instances", "instances_amodal")]
        for image in subject.readable.images(split):
            key = f"{image_name(image.scene_id, image.image_id)}.png"
            rows, whole = (table.get(key, []) for table in tables)
            _image_agrees(findings, subject, image, rows, whole)
            numbers |= {row.get("id") for row in rows}
            findings.count += len(rows)
    findings.require(
        len(numbers) == findings.count and 0 not in numbers,
        f"{coco_layout(subject.root).annotations}: numbers of annotations must be unique and begin with 1",
    )
    findings.examined = f"{findings.count} annotations and as many amodal ones"
    return findings


def panoptic(subject: Subject) -> Findings:
    """Compare the images of segment ids with the listed segments, and with the visible masks of the targets."""
    findings = Findings()
    for split in SPLITS:
        rows = _by_image(subject, "panoptic", split)
        for image in subject.readable.images(split):
            name = f"{image_name(image.scene_id, image.image_id)}.png"
            path = coco_layout(subject.root).segments(split) / name
            red, green, blue = np.moveaxis(decode_rgb(path).astype(int), -1, 0)
            numbers = red + 256 * green + 65536 * blue
            where = f"{coco_layout(subject.root).table('panoptic', split)}: {name}"
            listed = take(rows.get(name, [{}])[0], "segments_info", list, where)
            areas = {take(item, "id", int, where): take(item, "area", int, where) for item in listed}
            found = {int(n): int(c) for n, c in zip(*np.unique(numbers, return_counts=True), strict=True) if n}
            findings.require(areas == found, f"{where}: segments_info is not what the image shows")
            for target in image.targets:
                same = np.array_equal(
                    numbers == target.instance_id, subject.readable.mask_visible(image, target.gt_index)
                )
                findings.require(same, f"{path}: segment {target.instance_id} is not the visible mask of its target")
            findings.count += len(found)
    findings.examined = f"{findings.count} segments"
    return findings


def same_masks_as_bop(subject: Subject) -> Findings:
    """Every mask decodes to the PNG that BOP has of it."""
    findings = Findings()
    for split in SPLITS:
        tables = {name: _by_image(subject, name, split) for name in ("instances", "instances_amodal")}
        for image in subject.readable.images(split):
            key = f"{image_name(image.scene_id, image.image_id)}.png"
            folder = subject.layout.format_folder("bop") / split / f"{image.scene_id:06d}"
            for name, kind in (("instances", "mask_visib"), ("instances_amodal", "mask")):
                for index, row in enumerate(tables[name].get(key, [])):
                    path = folder / kind / f"{image.image_id:06d}_{index:06d}.png"
                    same = np.array_equal(_decoded(row, image, str(path)), decode_mask(path))
                    findings.require(same, f"{path}: differs from the mask in {name}_{split}.json")
                    findings.count += 1
    findings.examined = f"{findings.count} masks"
    return findings


def _by_image(subject: Subject, name: Any, split: str) -> dict[str, list[dict[str, Any]]]:
    """Return the annotations of a table by the name of the image's file."""
    path = coco_layout(subject.root).table(name, split)
    data, where = read_json(path), str(path)
    names = {
        take(row, "id", int, where): take(row, "file_name", str, where) for row in take(data, "images", list, where)
    }
    found: dict[str, list[dict[str, Any]]] = {}
    for row in take(data, "annotations", list, where):
        found.setdefault(names.get(take(row, "image_id", int, where), ""), []).append(row)
    return found


def _image_agrees(
    findings: Findings,
    subject: Subject,
    image: ImageRecord,
    rows: list[dict[str, Any]],
    whole: list[dict[str, Any]],
) -> None:
    where = f"{coco_layout(subject.root).annotations}: {image_name(image.scene_id, image.image_id)}"
    T_camera_world = invert(subject.T_world_camera(image.scene_id, image.image_id))
    placed = np.abs(image.T_world_camera @ T_camera_world - np.eye(4)).max() < _SAME_POSE
    findings.require(bool(placed), f"{where}: the camera is not where the scene record has it")
    if not findings.require(
        len(rows) == len(whole) == len(image.targets), f"{where}: instances and amodal ones are not the same targets"
    ):
        return
    taken = np.zeros((image.camera.height, image.camera.width), dtype=bool)
    for target, row, amodal in zip(image.targets, rows, whole, strict=True):
        here, item = f"{where}: target {target.gt_index}", subject.record(image.scene_id).object(target.instance_id)
        visible, amodal_mask = (_measured(findings, entry, image, here) for entry in (row, amodal))
        findings.require(not (visible & taken).any(), f"{here}: overlaps another one")
        findings.require(not (visible & ~amodal_mask).any(), f"{here}: is seen outside its amodal mask")
        findings.require(row.get("id") == amodal.get("id"), f"{here}: has two numbers")
        ignored = target.visible_fraction < _VISIBLE_ENOUGH
        findings.require(row.get("iscrowd") == int(ignored), f"{here}: iscrowd must be {int(ignored)}")
        taken |= visible
        if findings.require(item is not None, f"{here}: instance {target.instance_id} is not in the scene record"):
            assert item is not None
            moved = np.abs(target.T_camera_object - T_camera_world @ item.T_world_object).max()
            findings.require(bool(moved < _SAME_POSE), f"{here}: the pose differs from the scene record by {moved:.2e}")
            findings.require(target.obj_id == item.obj_id, f"{here}: obj_id is not {item.obj_id}")


def _measured(findings: Findings, row: dict[str, Any], image: ImageRecord, where: str) -> Bool[np.ndarray, "h w"]:
    """Return the mask of an entry whose area and box are held against it."""
    mask, runs = _decoded(row, image, where), row["segmentation"]
    box, area = take_numbers(row, "bbox", 4, where).tolist(), take(row, "area", int, where)
    findings.require(box == coco_mask.toBbox(runs).tolist(), f"{where}: bbox is {box}, not that of the mask")
    findings.require(area == int(coco_mask.area(runs)), f"{where}: area is {area}, not that of the mask")
    return mask


def _decoded(row: dict[str, Any], image: ImageRecord, where: str) -> Bool[np.ndarray, "h w"]:
    runs, shape = take(row, "segmentation", dict, where), (image.camera.height, image.camera.width)
    # pycocotools takes anything without a word: what it is given fills the image exactly.
    mask_of_runs(runs, shape, where)
    decoded: Bool[np.ndarray, "h w"] = coco_mask.decode(runs).astype(bool)
    return decoded


CHECKS = (
    NamedCheck("coco files", files),
    NamedCheck("coco instances", instances),
    NamedCheck("coco panoptic", panoptic),
    NamedCheck("coco and bop masks", same_masks_as_bop, compares_with="bop"),
)
