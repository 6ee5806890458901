"""Check that the KITTI and the BOP files agree, also where KITTI has a level camera in the place of a tilted one."""

import numpy as np

from warehouse_sim.dataset.checks.findings import Findings
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.files.extent import read_bytes
from warehouse_sim.dataset.files.image_io import decode_depth
from warehouse_sim.dataset.formats.bop import bop_layout
from warehouse_sim.dataset.formats.kitti import frames_of
from warehouse_sim.dataset.formats.kitti.checks.frames import (
    OTHER,
    T_world_image,
    file_of,
    is_levelled,
    read_camera,
    read_labels,
)
from warehouse_sim.dataset.formats.kitti.reader import KittiLabel
from warehouse_sim.dataset.records import ImageRecord, TargetRecord
from warehouse_sim.geometry.pose import invert

_FEW_PIXELS = 30
"""So few visible pixels can be none on another pixel grid."""
_STEPS_PER_METRE = np.float32(256.0)
_SAMPLE = 5_000
_SAME_LEVEL_DEPTH, _MOST = 0.05, 0.5
"""More than half of the readings agree so well, noise and edges included; relative to depth."""
_SAME_FRACTION = 1e-4
# Half a step of each format's depth, and float rounding.
_SAME_DEPTH = 0.5 / 256 + 0.5 / 1000 + 1e-4


def labels(subject: Subject) -> Findings:
    """Both formats list the same objects in the same order, with the same 2D box; their places are the scene record's.

    What leans is DontCare in KITTI and comes after the others. A level image holds more than the tilted one at its
    corners, and so may show more objects.
    """
    findings, count = Findings(), 0
    for image in subject.of_format(OTHER).images():
        frame = _frame(subject, image)
        rows = read_labels(subject, image.split, frame)
        where = f"frame {frame:06d}"
        targets = {target.instance_id: target for target in image.targets}
        if is_levelled(subject):
            count += len(rows)
            lost = set(targets) - {row.instance_id for row in rows}
            for number in sorted(item for item in lost if targets[item].pixels_visible >= _FEW_PIXELS):
                findings.require(False, f"{where}: object {number} of BOP has no label")
            continue
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


def _frame(subject: Subject, image: ImageRecord) -> int:
    return frames_of(subject.manifest, image.scene_id)[image.image_id]


def _same_level_depth(findings: Findings, subject: Subject, image: ImageRecord) -> None:
    """Require that what BOP's depth image shows lies where KITTI's has it, but for noise and edges."""
    frame = _frame(subject, image)
    path, level = file_of(subject, image.split, "depth_2", frame), read_camera(subject, image.split, frame)[0]
    steps, read = decode_depth(path), subject.of_format(OTHER).depth(image)
    known = np.flatnonzero(read)
    chosen = known[np.linspace(0, len(known) - 1, min(_SAMPLE, len(known))).astype(int)]
    v, u = np.unravel_index(chosen, read.shape)
    place = image.scene_id, image.image_id
    T = invert(T_world_image(subject, *place)) @ subject.T_world_camera(*place)
    points = (image.camera.rays_at(u, v) * read[v, u][:, None]) @ T[:3, :3].T
    at = np.rint(level.project(points)).astype(int)
    inside = ((at >= 0) & (at < [level.width, level.height])).all(axis=1)
    shown = steps[at[inside, 1], at[inside, 0]] / _STEPS_PER_METRE
    both = shown > 0
    off = np.abs(shown[both] / points[inside, 2][both] - 1.0)
    same = len(off) == 0 or bool((off < _SAME_LEVEL_DEPTH).mean() > _MOST)
    findings.require(same, f"{path.stem}: the depth images of KITTI and BOP are not of the same place")
