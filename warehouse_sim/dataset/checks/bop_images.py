"""Checks of the BOP images and masks, pixel by pixel."""

from typing import Any

import numpy as np
from jaxtyping import Bool, Float32

from warehouse_sim.dataset.checks.clean import NOT_ITS_TRUTH, reads
from warehouse_sim.dataset.checks.coco_mask import decode_runs
from warehouse_sim.dataset.checks.subject import Findings, Subject
from warehouse_sim.dataset.json_file import read_json, read_table
from warehouse_sim.dataset.plain import take
from warehouse_sim.dataset.reader import ImageRecord
from warehouse_sim.geometry.boxes import mask_box_xyxy


def images(subject: Subject) -> Findings:
    """Colour and depth images can be read and have the camera's size."""
    findings, count, reader = Findings(), 0, subject.reader
    for image in subject.images():
        pictures = {"rgb": reader.rgb(image), "depth": reader.depth(image)}
        if reader.has_clean:
            pictures |= {"rgb_clean": reader.clean_rgb(image), "depth_clean": reader.clean_depth(image)}
            where = f"{subject.bop.scene(image.split, image.scene_id).depth_clean(image.image_id)}"
            findings.require(reads(pictures["depth_clean"], pictures["depth"]), f"{where}: {NOT_ITS_TRUTH}")
        for name, pixels in pictures.items():
            where = f"{subject.bop.scene(image.split, image.scene_id).root / name}: image {image.image_id}"
            findings.require(bool(pixels.any()), f"{where}: holds nothing but zeros")
            count += 1
    findings.examined = f"{count} images"
    return findings


def masks(subject: Subject) -> Findings:
    """Visible masks lie in their silhouettes, do not overlap, and give the stored counts, boxes and run lengths."""
    findings, count = Findings(), 0
    for split, scene in subject.scenes():
        layout = subject.bop.scene(split, scene)
        infos, coco = read_table(layout.table("gt_info")), read_json(layout.table("gt_coco"))
        where = f"{layout.table('gt_coco')}: annotations"
        annotations = take(coco, "annotations", list, str(layout.table("gt_coco")))
        runs = iter([take(annotation, "segmentation", dict, where) for annotation in annotations])
        for image in (image for image in subject.reader.images(split) if image.scene_id == scene):
            taken = np.zeros((image.camera.height, image.camera.width), dtype=bool)
            depth = subject.reader.depth(image)
            for index, info in enumerate(infos[image.image_id]):
                visible = _mask_agrees(findings, subject, image, index, info, depth, next(runs, None))
                where = f"{layout.mask(image.image_id, index, visible=True)}"
                findings.require(not (taken & visible).any(), f"{where}: overlaps the visible mask of another object")
                taken |= visible
                count += 1
    findings.examined = f"{count} pairs of masks"
    return findings


def _mask_agrees(
    findings: Findings,
    subject: Subject,
    image: ImageRecord,
    index: int,
    info: dict[str, Any],
    depth: Float32[np.ndarray, "h w"],
    runs: dict[str, Any] | None,
) -> Bool[np.ndarray, "h w"]:
    where = str(subject.bop.scene(image.split, image.scene_id).mask(image.image_id, index, visible=True))
    whole, visible = subject.reader.mask(image, index), subject.reader.mask_visible(image, index)
    findings.require(not (visible & ~whole).any(), f"{where}: is not part of the whole silhouette")
    counted = int(visible.sum())
    findings.require(
        counted == info["px_count_visib"] > 0,
        f"{where}: has {counted} pixels, px_count_visib is {info['px_count_visib']}",
    )
    valid = int((whole & (depth > 0)).sum())
    findings.require(
        valid == info["px_count_valid"], f"{where}: {valid} readings, px_count_valid is {info['px_count_valid']}"
    )
    findings.require(int(whole.sum()) <= info["px_count_all"], f"{where}: px_count_all is less than its silhouette")
    share = counted / info["px_count_all"] if info["px_count_all"] else -1.0
    findings.require(abs(share - info["visib_fract"]) < 1e-9, f"{where}: visib_fract is not {share:.6f}")
    box = mask_box_xyxy(visible)
    stored = image.targets[index].box_visible_xyxy
    findings.require(
        box is not None and tuple(map(float, box)) == stored, f"{where}: bbox_visib is {stored}, not {box}"
    )
    decoded = decode_runs(runs, visible.shape, f"{where}: scene_gt_coco.json")
    findings.require(np.array_equal(decoded, visible), f"{where}: differs from the run lengths in scene_gt_coco.json")
    return visible
