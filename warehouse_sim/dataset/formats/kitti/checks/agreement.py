"""Check that the KITTI and the BOP files agree, also where KITTI has a level camera in the place of a tilted one."""

import math
from pathlib import Path

import numpy as np
from jaxtyping import Float

from warehouse_sim.dataset.checks.findings import Findings
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.files.extent import read_bytes
from warehouse_sim.dataset.files.image_io import decode_depth
from warehouse_sim.dataset.formats.bop import bop_layout
from warehouse_sim.dataset.formats.kitti import frames_of
from warehouse_sim.dataset.formats.kitti.checks.frames import (
    OTHER,
    LabelRow,
    T_world_image,
    file_of,
    is_levelled,
    read_camera,
    read_labels,
)
from warehouse_sim.dataset.formats.kitti.checks.labels import is_tilted
from warehouse_sim.dataset.formats.kitti.reader import KittiLabel
from warehouse_sim.dataset.records import ImageRecord, TargetRecord
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import same_lens
from warehouse_sim.geometry.pose import Transform, invert

_FEW_PIXELS = 30
"""So few visible pixels can be none on another pixel grid."""
_STEPS_PER_METRE = np.float32(256.0)
_SAMPLE = 5_000
_SAME_LEVEL_DEPTH, _MOST = 0.05, 0.5
"""More than half of the readings agree so well, noise and edges included; relative to depth."""
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
            count += _level_labels(findings, subject, image, rows, where)
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
            _same_level_camera(findings, subject, image)
            continue
        path, camera = _kitti_camera(subject, image)
        same_k = np.allclose(camera.K, image.camera.K, rtol=1e-9)
        findings.require(
            same_k and same_lens(camera.distortion, image.camera.distortion), f"{path}: is another camera than BOP's"
        )
    findings.examined = f"{count} pairs of cameras"
    return findings


def images(subject: Subject) -> Findings:
    """Colour images are equal byte for byte, depth images within their steps; of a level view, most depths are."""
    findings = subject.put_together(list(subject.of_format(OTHER).images()), lambda image: _same_images(subject, image))
    findings.examined = f"{findings.count} pairs of images"
    return findings


def _same_images(subject: Subject, image: ImageRecord) -> Findings:
    findings, frame = Findings(count=2), _frame(subject, image)
    if is_levelled(subject):
        _same_level_depth(findings, subject, image)
        return findings
    rgb_path = file_of(subject, image.split, "image_2", frame)
    bop_path = bop_layout(subject.root).scene(image.split, image.scene_id).image("rgb", image.image_id)
    pairs = [(rgb_path, bop_path)]
    if subject.manifest.contents.clean:
        clean_path = file_of(subject, image.split, "image_clean_2", frame)
        pairs.append(
            (clean_path, bop_layout(subject.root).scene(image.split, image.scene_id).image("rgb_clean", image.image_id))
        )
    for ours, theirs in pairs:
        findings.require(read_bytes(ours) == read_bytes(theirs), f"{ours}: differs from {theirs}")
    depth_path = file_of(subject, image.split, "depth_2", frame)
    steps, depth = decode_depth(depth_path), subject.of_format(OTHER).depth(image)
    if findings.require(steps.shape == depth.shape, f"{depth_path}: is not as large as BOP's"):
        difference = np.abs(steps / np.float32(256.0) - depth).max()
        findings.require(bool(difference <= _SAME_DEPTH), f"{depth_path}: differs from BOP's by {difference:.4f} m")
    return findings


def _same(
    findings: Findings, subject: Subject, row: KittiLabel, image: ImageRecord, target: TargetRecord, where: str
) -> None:
    _same_place(findings, subject, row, (target, target.T_camera_object), where)
    last = image.camera.width - 1, image.camera.height - 1
    box = np.clip(target.box_amodal_xyxy, 0, [*last, *last])
    findings.require(bool(np.abs(box - row.box_xyxy).max() < 0.01), f"{where}: the 2D boxes differ")
    if row.is_dont_care or (tuple(box) == target.box_amodal_xyxy and row.truncated == 0.0):
        return
    if "amodal_masks" not in subject.manifest.contents.outputs:
        return
    inside = np.count_nonzero(subject.of_format(OTHER).readable.mask(image, target.gt_index))
    cut_off = 1.0 - inside / max(target.pixels_all, 1)
    findings.require(
        bool(abs(row.truncated - cut_off) < _SAME_FRACTION),
        f"{where}: truncated is {row.truncated}, BOP's mask has {cut_off:.4f}",
    )


def _same_place(
    findings: Findings, subject: Subject, row: KittiLabel, found: tuple[TargetRecord, Transform], where: str
) -> None:
    """Hold a row against BOP's target and its pose in the camera of the row."""
    target, T_camera_object = found
    if row.is_dont_care:
        findings.require(is_tilted(T_camera_object), f"{where}: is DontCare in KITTI, but stands in BOP")
        return
    moved = float(np.abs(row.T_camera_object()[:3, 3] - T_camera_object[:3, 3]).max())
    findings.require(moved < _SAME_PLACE, f"{where}: KITTI and BOP place it {moved:.6f} m apart")
    turned = math.remainder(row.rotation_y - math.atan2(-T_camera_object[2, 0], T_camera_object[0, 0]), 2 * math.pi)
    findings.require(abs(turned) < _SAME_PLACE, f"{where}: KITTI and BOP turn it {turned:.6f} rad apart")
    class_name = subject.info(target.obj_id).class_name
    findings.require(row.type == class_name, f"{where}: is a {row.type} in KITTI and a {class_name} in BOP")


def _frame(subject: Subject, image: ImageRecord) -> int:
    return frames_of(subject.manifest, image.scene_id)[image.image_id]


def _level_labels(findings: Findings, subject: Subject, image: ImageRecord, rows: list[LabelRow], where: str) -> int:
    """Require that KITTI has what BOP shows, at the same place; return how many labels were compared.

    The level image holds more than the tilted one at its corners, and so may show more objects.
    """
    T_level_camera, row_of = _T_level_camera(subject, image), {row.instance_id: row.label for row in rows}
    for target in image.targets:
        listed = target.instance_id in row_of or target.pixels_visible < _FEW_PIXELS
        findings.require(listed, f"{where}: object {target.instance_id} of BOP has no label")
        if target.instance_id not in row_of:
            continue
        label, T_level_object = row_of[target.instance_id], T_level_camera @ target.T_camera_object
        _same_place(findings, subject, label, (target, T_level_object), f"{where}: object {target.instance_id}")
    return len(row_of)


def _same_level_camera(findings: Findings, subject: Subject, image: ImageRecord) -> None:
    """Require that the level image shows all that the tilted one shows, without a row or column to spare."""
    path, level = _kitti_camera(subject, image)
    same_focal = np.allclose([level.fx, level.fy], [image.camera.fx, image.camera.fy], rtol=1e-9)
    findings.require(same_focal, f"{path}: has another focal length than BOP's camera")
    rays = image.camera.border_rays() @ _T_level_camera(subject, image)[:3, :3].T
    if not findings.require(bool((rays[:, 2] > 0).all()), f"{path}: BOP's camera sees what is behind the level one"):
        return
    u, v = level.project(rays).T
    spare = np.array([u.min() + 0.5, v.min() + 0.5, level.width - 0.5 - u.max(), level.height - 0.5 - v.max()])
    tight = bool((spare > -1e-3).all() and (spare < 1.001).all())
    findings.require(
        tight, f"{path}: is not the least image that holds BOP's: {np.round(spare, 2).tolist()} px to spare"
    )


def _same_level_depth(findings: Findings, subject: Subject, image: ImageRecord) -> None:
    """Require that what BOP's depth image shows lies where KITTI's has it, but for noise and edges."""
    path, level = _kitti_camera(subject, image)
    steps, read = decode_depth(path.parents[1] / "depth_2" / f"{path.stem}.png"), subject.of_format(OTHER).depth(image)
    known = np.flatnonzero(read)
    chosen = known[np.linspace(0, len(known) - 1, min(_SAMPLE, len(known))).astype(int)]
    v, u = np.unravel_index(chosen, read.shape)
    T = _T_level_camera(subject, image)
    points = (image.camera.rays_at(u, v) * read[v, u][:, None]) @ T[:3, :3].T
    at = np.rint(level.project(points)).astype(int)
    inside = ((at >= 0) & (at < [level.width, level.height])).all(axis=1)
    shown = steps[at[inside, 1], at[inside, 0]] / _STEPS_PER_METRE
    both = shown > 0
    off = np.abs(shown[both] / points[inside, 2][both] - 1.0)
    same = len(off) == 0 or bool((off < _SAME_LEVEL_DEPTH).mean() > _MOST)
    findings.require(same, f"{path.stem}: the depth images of KITTI and BOP are not of the same place")


def _T_level_camera(subject: Subject, image: ImageRecord) -> Transform:
    T_world_level = T_world_image(subject, image.scene_id, image.image_id)
    turned: Float[np.ndarray, "4 4"] = invert(T_world_level) @ subject.T_world_camera(image.scene_id, image.image_id)
    return turned


def _kitti_camera(subject: Subject, image: ImageRecord) -> tuple[Path, PinholeCamera]:
    """Return the calib file of a frame and the camera that it describes."""
    frame = _frame(subject, image)
    return file_of(subject, image.split, "calib", frame), read_camera(subject, image.split, frame)[0]
