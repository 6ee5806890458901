"""Check that the KITTI and the BOP files agree; where they are of two cameras, ``level_agreement`` says how."""

import math

import numpy as np

from warehouse_sim.dataset.checks.findings import Findings, read_bytes, read_text
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.files.image_io import decode_depth
from warehouse_sim.dataset.formats.bop.layout import bop_layout
from warehouse_sim.dataset.formats.kitti.checks import level_agreement
from warehouse_sim.dataset.formats.kitti.checks.frames import OTHER, is_levelled
from warehouse_sim.dataset.formats.kitti.checks.labels import is_tilted, read_labels
from warehouse_sim.dataset.formats.kitti.label import KittiLabel
from warehouse_sim.dataset.formats.kitti.layout import frames_of, kitti_layout
from warehouse_sim.dataset.formats.kitti.reader import calib_camera, parse_calib
from warehouse_sim.dataset.records import ImageRecord, TargetRecord
from warehouse_sim.geometry.fisheye import same_lens

_SAME_PLACE = 1e-5
_SAME_FRACTION = 1e-4
# Half a step of each format's depth, and float rounding.
_SAME_DEPTH = 0.5 / 256 + 0.5 / 1000 + 1e-4


def labels(subject: Subject) -> Findings:
    """Both formats list the same objects in the same order, with the same place, heading and 2D box.

    What leans is DontCare in KITTI and comes after the others.
    """
    findings, count = Findings(), 0
    for image in subject.of_format(OTHER).images():
        frame = _frame(subject, image)
        rows = read_labels(subject, image.split, frame)
        where = f"frame {frame:06d}"
        if is_levelled(subject):
            count += level_agreement.labels(findings, subject, image, rows, where)
            continue
        targets = {target.instance_id: target for target in image.targets}
        leaning = {row.instance_id for row in rows if row.label.is_dont_care}
        listed = sorted(targets, key=lambda number: number in leaning)
        same = [row.instance_id for row in rows] == listed
        if not findings.require(same, f"{where}: KITTI labels and BOP poses are not of the same objects"):
            continue
        for number, row in enumerate(rows, start=1):
            _same(findings, subject, row.label, image, targets[row.instance_id], f"{where}, label {number}")
            count += 1
    findings.examined = f"{count} labels with their poses"
    return findings


def cameras(subject: Subject) -> Findings:
    """Both formats hold the same intrinsics and the same lens, or KITTI the level view of BOP's camera."""
    findings, count = Findings(), 0
    for image in subject.of_format(OTHER).images():
        count += 1
        if is_levelled(subject):
            level_agreement.camera(findings, subject, image)
            continue
        path = kitti_layout(subject.root).file(image.split, "calib", _frame(subject, image))
        size_wh = image.camera.width, image.camera.height
        camera = calib_camera(parse_calib(read_text(path), str(path)), size_wh)
        same_k = np.allclose(camera.K, image.camera.K, rtol=1e-9)
        findings.require(
            same_k and same_lens(camera.distortion, image.camera.distortion), f"{path}: is another camera than BOP's"
        )
    findings.examined = f"{count} pairs of cameras"
    return findings


def images(subject: Subject) -> Findings:
    """Colour images are equal byte for byte, depth images within their steps; of a level view, most depths are."""
    findings = Findings()
    for part in subject.each(list(subject.of_format(OTHER).images()), lambda image: _same_images(subject, image)):
        findings.add(part)
    findings.examined = f"{findings.count} pairs of images"
    return findings


def _same_images(subject: Subject, image: ImageRecord) -> Findings:
    findings, frame = Findings(count=2), _frame(subject, image)
    if is_levelled(subject):
        level_agreement.depth(findings, subject, image)
        return findings
    rgb_path = kitti_layout(subject.root).file(image.split, "image_2", frame)
    bop_path = bop_layout(subject.root).scene(image.split, image.scene_id).rgb(image.image_id)
    pairs = [(rgb_path, bop_path)]
    if subject.manifest.contents.clean:
        clean_path = kitti_layout(subject.root).file(image.split, "image_clean_2", frame)
        pairs.append(
            (clean_path, bop_layout(subject.root).scene(image.split, image.scene_id).rgb_clean(image.image_id))
        )
    for ours, theirs in pairs:
        findings.require(read_bytes(ours) == read_bytes(theirs), f"{ours}: differs from {theirs}")
    depth_path = kitti_layout(subject.root).file(image.split, "depth_2", frame)
    steps, depth = decode_depth(depth_path), subject.of_format(OTHER).depth(image)
    if findings.require(steps.shape == depth.shape, f"{depth_path}: is not as large as BOP's"):
        difference = np.abs(steps / np.float32(256.0) - depth).max()
        findings.require(bool(difference <= _SAME_DEPTH), f"{depth_path}: differs from BOP's by {difference:.4f} m")
    return findings


def _same(
    findings: Findings, subject: Subject, row: KittiLabel, image: ImageRecord, target: TargetRecord, where: str
) -> None:
    if row.is_dont_care:
        findings.require(is_tilted(target.T_camera_object), f"{where}: is DontCare in KITTI, but stands in BOP")
    else:
        _same_place(findings, subject, row, target, where)
    last = image.camera.width - 1, image.camera.height - 1
    box = np.clip(target.box_amodal_xyxy, 0, [*last, *last])
    findings.require(bool(np.abs(box - row.box_xyxy).max() < 0.01), f"{where}: the 2D boxes differ")
    if row.is_dont_care or (tuple(box) == target.box_amodal_xyxy and row.truncated == 0.0):
        return
    inside = np.count_nonzero(subject.of_format(OTHER).readable.mask(image, target.gt_index))
    cut_off = 1.0 - inside / max(target.pixels_all, 1)
    findings.require(
        bool(abs(row.truncated - cut_off) < _SAME_FRACTION),
        f"{where}: truncated is {row.truncated}, BOP's mask has {cut_off:.4f}",
    )


def _same_place(findings: Findings, subject: Subject, row: KittiLabel, target: TargetRecord, where: str) -> None:
    T_camera_object = target.T_camera_object
    moved = float(np.abs(row.T_camera_object()[:3, 3] - T_camera_object[:3, 3]).max())
    findings.require(moved < _SAME_PLACE, f"{where}: KITTI and BOP place it {moved:.6f} m apart")
    turned = math.remainder(row.rotation_y - math.atan2(-T_camera_object[2, 0], T_camera_object[0, 0]), 2 * math.pi)
    findings.require(abs(turned) < _SAME_PLACE, f"{where}: KITTI and BOP turn it {turned:.6f} rad apart")
    class_name = subject.info(target.obj_id).class_name
    findings.require(row.type == class_name, f"{where}: is a {row.type} in KITTI and a {class_name} in BOP")


def _frame(subject: Subject, image: ImageRecord) -> int:
    return frames_of(subject.manifest, image.scene_id)[image.image_id]
