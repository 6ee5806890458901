"""Checks of the BOP images, masks and images of exact data, pixel by pixel."""

import itertools
from typing import Any

import numpy as np
from jaxtyping import Bool, Float32

from warehouse_sim.dataset.checks.colour import OF_ANOTHER_PLACE, colour_problem, shows_edges_of
from warehouse_sim.dataset.checks.depth import NOT_ITS_GT, matches_reading, may_read_nothing
from warehouse_sim.dataset.checks.findings import Findings
from warehouse_sim.dataset.checks.labels import decode_runs, lie_apart
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.files.json_file import read_json, read_table
from warehouse_sim.dataset.files.plain import take
from warehouse_sim.dataset.formats.bop import bop_layout, image_kinds, mask_kinds
from warehouse_sim.dataset.formats.bop.reader import BopReader
from warehouse_sim.dataset.records import ImageRecord, TargetRecord
from warehouse_sim.geometry.boxes import mask_box_xyxy
from warehouse_sim.geometry.pose import transform_points


def images(subject: Subject) -> Findings:
    """Colour and depth images can be read and have the camera's size."""
    findings = subject.put_together(list(subject.images()), lambda image: _channels(subject, image))
    findings.examined = f"{findings.count} images"
    return findings


def masks(subject: Subject) -> Findings:
    """Visible masks lie in their amodal masks, do not overlap, and give the stored counts, boxes and run lengths."""
    rows, kinds = [], mask_kinds(subject.manifest.contents)
    for split, scene in subject.scenes():
        layout = bop_layout(subject.root).scene(split, scene)
        infos, runs = read_table(layout.table("gt_info")), list[dict[str, Any]]()
        if "mask_visib" in kinds:
            where = str(layout.table("gt_coco"))
            annotations = take(read_json(layout.table("gt_coco")), "annotations", list, where)
            runs = [take(annotation, "segmentation", dict, f"{where}: annotations") for annotation in annotations]
        for image in (image for image in subject.readable.images(split) if image.scene_id == scene):
            count = len(infos[image.image_id])
            rows.append((image, infos[image.image_id], runs[:count]))
            runs = runs[count:]
    findings = subject.put_together(rows, lambda row: _masks_of_image(subject, *row))
    findings.examined = f"{findings.count} {'pairs of masks' if len(kinds) > 1 else 'masks'}"
    return findings


def _channels(subject: Subject, image: ImageRecord) -> Findings:
    findings, reader = Findings(), subject.readable
    layout = bop_layout(subject.root).scene(image.split, image.scene_id)
    readers = {
        "rgb": reader.rgb,
        "depth": subject.depth,
        "rgb_clean": reader.clean_rgb,
        "depth_clean": reader.clean_depth,
    }
    channels = {kind: readers[kind](image) for kind in image_kinds(subject.manifest.contents)}
    if {"depth", "depth_clean"} <= channels.keys():
        is_gt = matches_reading(channels["depth_clean"], channels["depth"])
        findings.require(is_gt, f"{layout.image('depth_clean', image.image_id)}: {NOT_ITS_GT}")
    if {"rgb", "rgb_clean"} <= channels.keys():
        wrong = colour_problem(channels["rgb_clean"], channels["rgb"])
        findings.require(not wrong, f"{layout.image('rgb_clean', image.image_id)}: {wrong}")
    depth = channels.get("depth_clean", channels.get("depth"))
    if "rgb" in channels and depth is not None:
        shown = shows_edges_of(channels["rgb"], depth)
        findings.require(shown, f"{layout.image('rgb', image.image_id)}: {OF_ANOTHER_PLACE}")
    for name, pixels in channels.items():
        where = f"{layout.root / name}: image {image.image_id}"
        far = name == "depth" and may_read_nothing(subject, image.scene_id, image.image_id)
        findings.require(far or bool(pixels.any()), f"{where}: holds nothing but zeros")
        findings.count += 1
    return findings


def _masks_of_image(
    subject: Subject, image: ImageRecord, infos: list[dict[str, Any]], runs: list[dict[str, Any]]
) -> Findings:
    findings, outputs = Findings(), subject.manifest.contents.outputs
    layout = bop_layout(subject.root).scene(image.split, image.scene_id)
    taken = np.zeros((image.camera.height, image.camera.width), dtype=bool)
    for index, (info, segmentation) in enumerate(itertools.zip_longest(infos, runs[: len(infos)])):
        findings.count += 1
        whole = subject.readable.mask(image, index) if "amodal_masks" in outputs else None
        if whole is not None:
            where = str(layout.mask("mask", image.image_id, index))
            _whole_box_agrees(findings, image, image.targets[index], whole, where)
            _whole_counts_agree(findings, info, whole, subject.depth(image) if "depth" in outputs else None, where)
        if "masks" not in outputs:
            continue
        where = str(layout.mask("mask_visib", image.image_id, index))
        visible = subject.readable.mask_visible(image, index)
        lie_apart(findings, visible, whole, taken, where)
        _counts_agree(findings, info, visible, where)
        box, stored = mask_box_xyxy(visible), image.targets[index].box_visible_xyxy
        same_box = box is not None and tuple(map(float, box)) == stored
        findings.require(same_box, f"{where}: bbox_visib is {stored}, not {box}")
        decoded = decode_runs(segmentation, image, f"{where}: scene_gt_coco.json")
        same = np.array_equal(decoded, visible)
        findings.require(same, f"{where}: differs from the run lengths in scene_gt_coco.json")
    return findings


def _whole_counts_agree(
    findings: Findings,
    info: dict[str, Any],
    whole: Bool[np.ndarray, "h w"],
    depth: Float32[np.ndarray, "h w"] | None,
    where: str,
) -> None:
    """Hold the counts of the whole amodal mask against it, those of its readings only where depth is stored."""
    inside = np.count_nonzero(whole)
    findings.require(inside <= info["px_count_all"], f"{where}: px_count_all is less than its amodal mask")
    valid = info["px_count_valid"] if depth is None else np.count_nonzero(depth[whole])
    findings.require(
        valid == info["px_count_valid"], f"{where}: {valid} readings, px_count_valid is {info['px_count_valid']}"
    )


def _counts_agree(findings: Findings, info: dict[str, Any], visible: Bool[np.ndarray, "h w"], where: str) -> None:
    counted = np.count_nonzero(visible)
    findings.require(
        counted == info["px_count_visib"] > 0,
        f"{where}: has {counted} pixels, px_count_visib is {info['px_count_visib']}",
    )
    fraction = counted / info["px_count_all"] if info["px_count_all"] else -1.0
    findings.require(abs(fraction - info["visib_fract"]) < 1e-9, f"{where}: visib_fract is not {fraction:.6f}")


def _whole_box_agrees(
    findings: Findings, image: ImageRecord, target: TargetRecord, whole: Bool[np.ndarray, "h w"], where: str
) -> None:
    """Hold box and count of the whole amodal mask against its mask, which ends at the image border."""
    box, stored = mask_box_xyxy(whole), np.array(target.box_amodal_xyxy)
    last = np.array([image.camera.width - 1, image.camera.height - 1] * 2)
    is_cut = bool((stored != np.clip(stored, 0, last)).any())
    found = np.zeros(4) if box is None else np.array(box, dtype=float)
    # What is cut off may be where the amodal mask is widest.
    same = (found == stored) | (is_cut & np.array([*(found[:2] > stored[:2]), *(found[2:] < stored[2:])]))
    findings.require(bool(same.all()), f"{where}: bbox_obj is {target.box_amodal_xyxy}, the mask has {box}")
    counted = np.count_nonzero(whole)
    findings.require(
        bool(counted < target.pixels_all if is_cut else counted == target.pixels_all),
        f"{where}: px_count_all is {target.pixels_all}, {counted} of them lie in the image, "
        f"{'where the border cuts some off' if is_cut else 'as does the whole box'}",
    )


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
