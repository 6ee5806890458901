"""Checks of YOLO files."""

import numpy as np

from warehouse_sim.dataset.checks.findings import Findings, NamedCheck, compare_names
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.files.image_io import decode_mask
from warehouse_sim.dataset.formats.yolo import TASKS, YoloLayout, yolo_layout
from warehouse_sim.dataset.formats.yolo.reader import YoloReader
from warehouse_sim.dataset.layout import observation_name
from warehouse_sim.dataset.split import SPLITS
from warehouse_sim.geometry.boxes import mask_box_xyxy

_SAME_PX = 0.01
"""How far edges may be off: shares are written with seven digits."""


def _layouts(subject: Subject) -> list[YoloLayout]:
    layouts = [yolo_layout(subject.root, task) for task in TASKS]
    has_pockets = any(info.pockets for info in subject.objects.values())
    return [item for item in layouts if item.root.name != "pose" or has_pockets]


def files(subject: Subject) -> Findings:
    """Each task has an image and a label file of every observation, and no other."""
    findings = Findings()
    for layout in _layouts(subject):
        for split in SPLITS:
            names = {observation_name(scene, index) for name, scene, index in subject.observations() if name == split}
            compare_names(findings, layout.images(split), {f"{name}.png" for name in names})
            compare_names(findings, layout.labels(split), {f"{name}.txt" for name in names})
            findings.count += len(names)
    findings.examined = f"{findings.count} images and label files"
    return findings


def labels(subject: Subject) -> Findings:
    """Rows can be read, are in the image, and are as many in every task as the scene records have targets."""
    findings = Findings()
    for layout in _layouts(subject):
        reader = YoloReader(layout.root)
        findings.require(
            sorted(info.class_name for info in reader.objects.values()) == sorted(subject.manifest.targets),
            f"{layout.data}: names are not the targets of the manifest",
        )
        for split in SPLITS:
            places = _places(subject, split)
            for image, (scene, index) in zip(reader.images(split), places, strict=False):
                found, expected = len(image.targets), len(subject.record(scene).observations[index].targets)
                where = layout.labels(split) / f"{observation_name(scene, index)}.txt"
                findings.require(found == expected, f"{where}: {found} rows, the scene record has {expected} targets")
                findings.count += found
    findings.examined = f"{findings.count} rows"
    return findings


def same_boxes_as_bop(subject: Subject) -> Findings:
    """Boxes are those of BOP's visible masks."""
    findings, layout = Findings(), yolo_layout(subject.root, "detect")
    reader = YoloReader(layout.root)
    for split in SPLITS:
        for image, (scene, index) in zip(reader.images(split), _places(subject, split), strict=False):
            for target in image.targets:
                folder = subject.layout.format_folder("bop") / split / f"{scene:06d}" / "mask_visib"
                path = folder / f"{index:06d}_{target.gt_index:06d}.png"
                box = mask_box_xyxy(decode_mask(path))
                same = box is not None and np.abs(np.subtract(box, target.box_visible_xyxy)).max() < _SAME_PX
                where = f"{layout.labels(split) / observation_name(scene, index)}.txt: row {target.gt_index + 1}"
                findings.require(bool(same), f"{where} is not the box of {path.name}, {box}")
                findings.count += 1
    findings.examined = f"{findings.count} boxes"
    return findings


def _places(subject: Subject, split: str) -> list[tuple[int, int]]:
    """Return scene and observation of each image of a split, as their names are sorted."""
    return sorted((scene, index) for name, scene, index in subject.observations() if name == split)


CHECKS = (
    NamedCheck("yolo files", files),
    NamedCheck("yolo labels", labels),
    NamedCheck("yolo and bop boxes", same_boxes_as_bop, compares_with="bop"),
)
