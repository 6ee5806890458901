"""Checks of COCO files; masks are decoded by pycocotools."""

from collections.abc import Sequence
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
from warehouse_sim.dataset.formats.coco import Table, coco_layout, tables_of
from warehouse_sim.dataset.layout import observation_name
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.dataset.split import SPLITS


def files(subject: Subject) -> Findings:
    """Each split holds the images of its observations, the images of their segments, its tables, and no more."""
    findings, layout = Findings(), coco_layout(subject.root)
    folders, names = {f"panoptic_{split}" for split in SPLITS}, tables_of(subject.manifest.contents)
    compare_names(findings, layout.annotations, {f"{n}_{s}.json" for n in names for s in SPLITS} | folders)
    for split in SPLITS:
        found = [(scene, index) for name, scene, index in subject.observations() if name == split]
        images = {f"{observation_name(scene, index)}.png" for scene, index in found}
        compare_names(findings, layout.images(split), images)
        compare_names(findings, layout.segments(split), images)
        findings.count += 2 * len(images)
    findings.examined = f"{findings.count} images"
    return findings


def instances(subject: Subject) -> Findings:
    """Compare annotations with the scene records, and areas and boxes with the masks; no two masks overlap."""
    findings, numbers = Findings(), set()
    for split in SPLITS:
        tables = {name: _by_image(subject, name, split) for name in _tables_of_instances(subject)}
        whole = tables.get("instances_amodal")
        for image in subject.readable.images(split):
            key = f"{observation_name(image.scene_id, image.image_id)}.png"
            rows = tables["instances"].get(key, [])
            _image_agrees(findings, subject, image, rows, None if whole is None else whole.get(key, []))
            numbers |= {take(row, "id", int, f"{coco_layout(subject.root).annotations}: {key}") for row in rows}
            findings.count += len(rows)
    findings.require(
        len(numbers) == findings.count and 0 not in numbers,
        f"{coco_layout(subject.root).annotations}: numbers of annotations must be unique and begin with 1",
    )
    also = " and as many amodal ones" if len(_tables_of_instances(subject)) > 1 else ""
    findings.examined = f"{findings.count} annotations{also}"
    return findings


def _tables_of_instances(subject: Subject) -> list[Table]:
    return [name for name in tables_of(subject.manifest.contents) if name != "panoptic"]


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
        tables = {name: _by_image(subject, name, split) for name in _tables_of_instances(subject)}
        for image in subject.readable.images(split):
            key = f"{observation_name(image.scene_id, image.image_id)}.png"
            folder = subject.layout.format_folder("bop") / split / f"{image.scene_id:06d}"
            for name, rows in tables.items():
                for index, row in enumerate(rows.get(key, [])):
                    kind = "mask_visib" if name == "instances" else "mask"
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
    whole: list[dict[str, Any]] | None,
) -> None:
    where = f"{coco_layout(subject.root).annotations}: {observation_name(image.scene_id, image.image_id)}"
    agree_with_record(findings, subject, image, where)
    same = len(rows) == len(image.targets) and (whole is None or len(whole) == len(rows))
    if not findings.require(same, f"{where}: instances and amodal ones are not the same targets"):
        return
    taken = np.zeros((image.camera.height, image.camera.width), dtype=bool)
    amodal_rows: Sequence[dict[str, Any] | None] = [None] * len(rows) if whole is None else whole
    for target, row, amodal in zip(image.targets, rows, amodal_rows, strict=True):
        here = f"{where}[{target.gt_index}]"
        visible = _measured(findings, row, image, here)
        amodal_mask = None if amodal is None else _measured(findings, amodal, image, here)
        lie_apart(findings, visible, amodal_mask, taken, here)
        findings.require(amodal is None or row.get("id") == amodal.get("id"), f"{here}: has two numbers")
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
