"""Check that KITTI files of a level virtual camera agree with the BOP files of the tilted camera in its place."""

import math
from pathlib import Path

import numpy as np
from jaxtyping import Float

from warehouse_sim.dataset.checks.findings import Findings, read_text
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.files.image_io import decode_depth, png_size_wh
from warehouse_sim.dataset.formats.kitti.checks.frames import OTHER, T_world_image
from warehouse_sim.dataset.formats.kitti.checks.labels import LabelRow, is_tilted
from warehouse_sim.dataset.formats.kitti.layout import frames_of, kitti_layout
from warehouse_sim.dataset.formats.kitti.reader import calib_camera, parse_calib
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, invert

_SAME_PLACE = 1e-5
_FEW_PIXELS = 30
"""So few visible pixels can be none on another pixel grid."""
_STEPS_PER_METRE = np.float32(256.0)
_SAMPLE = 5_000
_SAME_DEPTH, _MOST = 0.05, 0.5
"""More than half of the readings agree so well, noise and edges included; relative to depth."""


def labels(findings: Findings, subject: Subject, image: ImageRecord, rows: list[LabelRow], where: str) -> int:
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
        place = f"{where}: object {target.instance_id}"
        if label.is_dont_care:
            findings.require(is_tilted(T_level_object), f"{place} is DontCare in KITTI, but stands in BOP")
            continue
        moved = float(np.abs(label.T_camera_object()[:3, 3] - T_level_object[:3, 3]).max())
        findings.require(moved < _SAME_PLACE, f"{place}: KITTI and BOP place it {moved:.6f} m apart")
        turned = math.remainder(label.rotation_y - math.atan2(-T_level_object[2, 0], T_level_object[0, 0]), 2 * math.pi)
        findings.require(abs(turned) < _SAME_PLACE, f"{place}: KITTI and BOP turn it {turned:.6f} rad apart")
    return len(row_of)


def camera(findings: Findings, subject: Subject, image: ImageRecord) -> None:
    """Require that the level image shows all that the tilted one shows, without a row or column to spare."""
    path, level = _level_camera(subject, image)
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


def depth(findings: Findings, subject: Subject, image: ImageRecord) -> None:
    """Require that what BOP's depth image shows lies where KITTI's has it, but for noise and edges."""
    path, level = _level_camera(subject, image)
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
    same = len(off) == 0 or bool((off < _SAME_DEPTH).mean() > _MOST)
    findings.require(same, f"{path.stem}: the depth images of KITTI and BOP are not of the same place")


def _T_level_camera(subject: Subject, image: ImageRecord) -> Transform:
    T_world_level = T_world_image(subject, image.scene_id, image.image_id)
    turned: Float[np.ndarray, "4 4"] = invert(T_world_level) @ subject.T_world_camera(image.scene_id, image.image_id)
    return turned


def _level_camera(subject: Subject, image: ImageRecord) -> tuple[Path, PinholeCamera]:
    """Return the calib file of a frame and the camera that it describes."""
    layout, frame = kitti_layout(subject.root), frames_of(subject.manifest, image.scene_id)[image.image_id]
    path = layout.file(image.split, "calib", frame)
    size_wh = png_size_wh(layout.file(image.split, "image_2", frame))
    return path, calib_camera(parse_calib(read_text(path), str(path)), size_wh)
