"""Checks of COCO files; masks are decoded by pycocotools."""

from typing import Any

import numpy as np
from jaxtyping import Bool
from pycocotools import mask as coco_mask

from warehouse_sim.dataset.checks.findings import Findings, NamedCheck, compare_names
from warehouse_sim.dataset.checks.labels import VISIBLE_ENOUGH, agree_with_record, decode_runs, lie_apart
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.files.image_io import decode_mask, decode_rgb
from warehouse_sim.dataset.files.json_file import read_json
from warehouse_sim.dataset.files.plain import take, take_numbers
from warehouse_sim.dataset.formats.coco.layout import TABLES, coco_layout
from warehouse_sim.dataset.layout import observation_name
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.dataset.split import SPLITS


def files(subject: Subject) -> Findings:
    """Each split holds the images of its observations, the images of their segments, three tables, and no more."""
    findings, layout = Findings(), coco_layout(subject.root)
    folders = {f"panoptic_{split}" for split in SPLITS}
    compare_names(findings, layout.annotations, {f"{n}_{s}.json" for n in TABLES for s in SPLITS} | folders)
    for split in SPLITS:
        found = [(scene, index) for name, scene, index in subject.observations() if name == split]
        names = {f"{observation_name(scene, index)}.png" for scene, index in found}
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
            key = f"{observation_name(image.scene_id, image.image_id)}.png"
            rows, whole = (table.get(key, []) for table in tables)
            _image_agrees(findings, subject, image, rows, whole)
            numbers |= {take(row, "id", int, f"{coco_layout(subject.root).annotations}: {key}") for row in rows}
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
            name = f"{observation_name(image.scene_id, image.image_id)}.png"
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
            key = f"{observation_name(image.scene_id, image.image_id)}.png"
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
    where = f"{coco_layout(subject.root).annotations}: {observation_name(image.scene_id, image.image_id)}"
    agree_with_record(findings, subject, image, where)
    if not findings.require(
        len(rows) == len(whole) == len(image.targets), f"{where}: instances and amodal ones are not the same targets"
    ):
        return
    taken = np.zeros((image.camera.height, image.camera.width), dtype=bool)
    for target, row, amodal in zip(image.targets, rows, whole, strict=True):
        here = f"{where}[{target.gt_index}]"
        visible, amodal_mask = (_measured(findings, entry, image, here) for entry in (row, amodal))
        lie_apart(findings, visible, amodal_mask, taken, here)
        findings.require(row.get("id") == amodal.get("id"), f"{here}: has two numbers")
        ignored = target.visible_fraction < VISIBLE_ENOUGH
        findings.require(row.get("iscrowd") == int(ignored), f"{here}: iscrowd must be {int(ignored)}")


def _measured(findings: Findings, row: dict[str, Any], image: ImageRecord, where: str) -> Bool[np.ndarray, "h w"]:
    """Return the mask of an entry whose area and box are held against it."""
    mask, runs = _decoded(row, image, where), row["segmentation"]
    box, area = take_numbers(row, "bbox", 4, where).tolist(), take(row, "area", int, where)
    findings.require(box == coco_mask.toBbox(runs).tolist(), f"{where}: bbox is {box}, not that of the mask")
    findings.require(area == int(coco_mask.area(runs)), f"{where}: area is {area}, not that of the mask")
    return mask


def _decoded(row: dict[str, Any], image: ImageRecord, where: str) -> Bool[np.ndarray, "h w"]:
    return decode_runs(take(row, "segmentation", dict, where), image, where)


CHECKS = (
    NamedCheck("coco files", files),
    NamedCheck("coco instances", instances),
    NamedCheck("coco panoptic", panoptic),
    NamedCheck("coco and bop masks", same_masks_as_bop, compares_with="bop"),
)
