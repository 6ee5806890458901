"""Checks of the KITTI folder: files, lists, calibration, images."""

from pathlib import Path

import numpy as np
from jaxtyping import Float

from warehouse_sim.dataset.checks.colour import OF_ANOTHER_PLACE, colour_problem, shows_edges_of
from warehouse_sim.dataset.checks.depth import NOT_ITS_GT, matches_reading, may_read_nothing
from warehouse_sim.dataset.checks.findings import Findings, compare_names, read_text
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.files.image_io import decode_depth, decode_rgb, image_size_wh
from warehouse_sim.dataset.formats.kitti import kitti_kinds, kitti_layout
from warehouse_sim.dataset.formats.kitti.checks.frames import (
    OTHER,
    T_world_image,
    file_of,
    frames,
    is_level,
    is_levelled,
    read_camera,
)
from warehouse_sim.dataset.formats.kitti.reader import CALIB_KEYS
from warehouse_sim.dataset.formats.kitti.tolerant import OUR_SHAPES, read_matrices, read_plane
from warehouse_sim.dataset.split import SPLITS, Split
from warehouse_sim.geometry.lens import Fisheye
from warehouse_sim.geometry.pose import invert, make_transform

_SAME_PLACE = 1e-5


def files(subject: Subject) -> Findings:
    """Each folder holds the frames of its splits and nothing else, and the lists name them."""
    findings, kinds = Findings(), kitti_kinds(subject.manifest.contents)
    by_split: dict[Split, set[int]] = {split: set() for split in SPLITS}
    for split, _, _, frame in frames(subject):
        by_split[split].add(frame)
    folders: dict[Split, set[int]] = {"train": by_split["train"] | by_split["val"], "test": by_split["test"]}
    for split, numbers in folders.items():
        for kind, ending in kinds.items():
            names = {f"{frame:06d}.{ending}" for frame in numbers}
            compare_names(findings, kitti_layout(subject.root).folder(split) / kind, names)
    sets: dict[str, set[int]] = {name: by_split[name] for name in SPLITS} | {
        "trainval": by_split["train"] | by_split["val"]
    }
    for name, numbers in sets.items():
        path = kitti_layout(subject.root).image_set(name)
        listed = read_text(path).split("\n")[:-1]
        findings.require(
            listed == [f"{frame:06d}" for frame in sorted(numbers)], f"{path}: is not the manifest's split"
        )
    findings.examined = f"{sum(map(len, by_split.values()))} frames, {len(kinds)} files each"
    return findings


def calib(subject: Subject) -> Findings:
    """Calib files have seven lines, rigid, no rotation hidden in P2, and the recipe's lens; planes are the floor."""
    findings, count, keys = Findings(), 0, _keys(subject)
    for split, scene, observation, frame in frames(subject):
        path = file_of(subject, split, "calib", frame)
        text = read_text(path)
        matrices = read_matrices(text, str(path), OUR_SHAPES)
        has_lines = [line.partition(":")[0] for line in text.split("\n")] == [*keys, ""] and list(matrices) == keys
        lines = f"{path}: must have the lines {', '.join(keys)}, with single blanks"
        if not findings.require(has_lines and "  " not in text, lines):
            continue
        findings.require(bool((matrices["P2"][2] == [0, 0, 1, 0]).all()), f"{path}: P2 must end in 0 0 1 0")
        same = all(np.array_equal(matrices[a], matrices[b]) for a, b in (("P0", "P2"), ("P1", "P3")))
        findings.require(same, f"{path}: P0 must be P2 and P1 must be P3, since there are two cameras and not four")
        findings.require(_is_the_recipes(matrices, subject), f"{path}: P2 is not the camera of the recipe")
        findings.require(_is_pair(matrices, subject), f"{path}: P3 must be P2 moved along x by the recipe's baseline")
        findings.require(_has_lens(matrices, subject), f"{path}: K_0x must be that of P2, D_0x or F_0x the rig's lens")
        for key in ("R0_rect", "Tr_velo_to_cam", "Tr_imu_to_velo"):
            findings.require(_is_rigid(matrices[key]), f"{path}: {key} is not a rotation")
        if subject.manifest.contents.lidars:
            _further_lidars(findings, subject, file_of(subject, split, "calib_lidars", frame))
        T_here = T_world_image(subject, scene, observation)
        lidar = matrices["Tr_velo_to_cam"]
        T_world_points = T_here @ make_transform(lidar[:, :3], lidar[:, 3])
        is_level(findings, T_world_points, subject.record(scene).observations[observation], f"{path}: Tr_velo_to_cam")
        if is_levelled(subject):
            _is_least_level_camera(findings, subject, (split, scene, observation, frame), str(path))
        plane_path = file_of(subject, split, "planes", frame)
        plane, T_camera_world = read_text(plane_path), invert(T_here)
        expected = np.array([*T_camera_world[:3, 2], -T_camera_world[:3, 2] @ T_camera_world[:3, 3]])
        is_floor = plane.count("\n") == 4 and np.abs(read_plane(plane, str(plane_path)) - expected).max() < _SAME_PLACE
        findings.require(bool(is_floor), f"{plane_path}: is not the floor's plane, in the fourth line")
        count += 1
    findings.examined = f"{count} files of 7 lines and as many planes"
    return findings


def _keys(subject: Subject) -> list[str]:
    """Return what the lines of a calib file begin with: those of KITTI, then those of each camera's lens."""
    lens = None if is_levelled(subject) else subject.manifest.contents.distortion
    eyes = ("02",) if subject.manifest.contents.baseline is None else ("02", "03")
    kind = "F" if isinstance(lens, Fisheye) else "D"
    return [*CALIB_KEYS, *(f"{key}_{eye}" for eye in eyes if lens for key in ("K", kind))]


def _further_lidars(findings: Findings, subject: Subject, path: Path) -> None:
    keys = [f"Tr_{name}_to_cam" for name in subject.manifest.contents.lidars]
    poses = read_matrices(read_text(path), str(path), dict.fromkeys(keys, (3, 4)))
    findings.require(list(poses) == keys, f"{path}: a line for each of {', '.join(keys)} is expected")
    for key, pose in poses.items():
        findings.require(_is_rigid(pose), f"{path}: {key} is not a rotation and a place")


def _is_least_level_camera(
    findings: Findings, subject: Subject, frame: tuple[Split, int, int, int], where: str
) -> None:
    """Require that the level image shows all that the tilted one shows, without a row or column to spare."""
    split, scene, observation, number = frame
    if subject.manifest.contents.camera is None:
        return
    level, tilted = read_camera(subject, split, number)[0], subject.manifest.contents.camera.make()
    same_focal = np.allclose([level.fx, level.fy], [tilted.fx, tilted.fy], rtol=1e-9)
    findings.require(same_focal, f"{where}: has another focal length than the camera of the recipe")
    T_level_camera = invert(T_world_image(subject, scene, observation)) @ subject.T_world_camera(scene, observation)
    rays = tilted.border_rays() @ T_level_camera[:3, :3].T
    if not findings.require(bool((rays[:, 2] > 0).all()), f"{where}: the rig's camera sees what is behind this one"):
        return
    u, v = level.project(rays).T
    spare = np.array([u.min() + 0.5, v.min() + 0.5, level.width - 0.5 - u.max(), level.height - 0.5 - v.max()])
    tight = bool((spare > -1e-3).all() and (spare < 1.001).all())
    shown = np.round(spare, 2).tolist()
    findings.require(tight, f"{where}: is not the least image that holds the rig's: {shown} px to spare")


def images(subject: Subject) -> Findings:
    """Read every colour and depth image: one size, and not empty.

    With BOP files in the dataset the colour images are not decoded a second time: another check compares their bytes.
    """
    findings = subject.put_together(list(frames(subject)), lambda frame: _channels(subject, *frame))
    findings.examined = f"{findings.count} images"
    return findings


def _channels(subject: Subject, split: Split, scene: int, observation: int, frame: int) -> Findings:
    findings, kinds = Findings(count=2), kitti_kinds(subject.manifest.contents)
    rgb_path, depth_path = (file_of(subject, split, kind, frame) for kind in ("image_2", "depth_2"))
    steps, size_wh = decode_depth(depth_path), image_size_wh(rgb_path)
    findings.require(steps.shape == size_wh[::-1], f"{depth_path}: is {steps.shape}, its image {size_wh[::-1]} (h, w)")
    far = may_read_nothing(subject, scene, observation)
    findings.require(far or bool(steps.any()), f"{depth_path}: holds nothing but zeros")
    if "depth_clean_2" in kinds:
        clean_path = file_of(subject, split, "depth_clean_2", frame)
        findings.require(matches_reading(decode_depth(clean_path), steps), f"{clean_path}: {NOT_ITS_GT}")
        clean_path = file_of(subject, split, "image_clean_2", frame)
        if OTHER not in subject.manifest.formats or is_levelled(subject):
            wrong = colour_problem(decode_rgb(clean_path), decode_rgb(rgb_path))
            findings.require(not wrong, f"{clean_path}: {wrong}")
    if "image_3" in kinds:
        _right_image(findings, subject, split, frame, size_wh)
    if OTHER not in subject.manifest.formats or is_levelled(subject):
        rgb = decode_rgb(rgb_path)
        findings.require(bool(rgb.any()), f"{rgb_path}: holds nothing but zeros")
        clean = "depth_clean_2" in kinds
        gt = decode_depth(file_of(subject, split, "depth_clean_2", frame)) if clean else steps
        shown = gt.shape != rgb.shape[:2] or shows_edges_of(rgb, gt.astype(np.float32) / 256.0)
        findings.require(shown, f"{rgb_path}: {OF_ANOTHER_PLACE}")
    return findings


def _right_image(findings: Findings, subject: Subject, split: Split, frame: int, size_wh: tuple[int, int]) -> None:
    rgb_path, disparity_path = (file_of(subject, split, kind, frame) for kind in ("image_3", "disp_occ"))
    image, steps = decode_rgb(rgb_path), decode_depth(disparity_path)
    findings.require(image.shape[1::-1] == size_wh, f"{rgb_path}: is not as large as image_2")
    findings.require(steps.shape == size_wh[::-1], f"{disparity_path}: is not as large as image_2")
    seen_path = file_of(subject, split, "disp_noc", frame)
    seen = decode_depth(seen_path)
    part = seen.shape == steps.shape and bool(((seen == 0) | (seen == steps)).all())
    findings.require(part, f"{seen_path}: is no part of disp_occ")
    findings.require(bool(image.any() and steps.any()), f"{rgb_path} or {disparity_path}: holds nothing but zeros")
    if "image_clean_3" in kitti_kinds(subject.manifest.contents):
        clean_path = file_of(subject, split, "image_clean_3", frame)
        wrong = colour_problem(decode_rgb(clean_path), image)
        findings.require(not wrong, f"{clean_path}: {wrong}")
    if "disp_sgbm" in kitti_kinds(subject.manifest.contents):
        matched_path = file_of(subject, split, "disp_sgbm", frame)
        findings.require(decode_depth(matched_path).shape == steps.shape, f"{matched_path}: is not as large as image_2")


def _is_pair(matrices: dict[str, Float[np.ndarray, "rows columns"]], subject: Subject) -> bool:
    """Return whether the right camera is the left one, moved by the recipe's baseline, 0 without a right camera."""
    moved = np.zeros((3, 4))
    moved[0, 3] = -matrices["P2"][0, 0] * (subject.manifest.contents.baseline or 0.0)
    return bool(np.abs(matrices["P3"] - matrices["P2"] - moved).max() < _SAME_PLACE)


def _is_the_recipes(matrices: dict[str, Float[np.ndarray, "rows columns"]], subject: Subject) -> bool:
    """Return whether P2 holds the recipe's camera; a level view in its place has an image of its own."""
    camera = subject.manifest.contents.camera
    if camera is None or is_levelled(subject):
        return True
    return bool(np.allclose(matrices["P2"][:, :3], camera.make().K, rtol=1e-9))


def _has_lens(matrices: dict[str, Float[np.ndarray, "rows columns"]], subject: Subject) -> bool:
    """Return whether each camera that has a lens has that of the recipe, behind the pinhole of P2."""
    lens = subject.manifest.contents.distortion
    same_k = all(
        np.abs(matrix - matrices["P2"][:, :3]).max() < _SAME_PLACE for key, matrix in matrices.items() if key[0] == "K"
    )
    lenses = [matrix for key, matrix in matrices.items() if key[:2] in ("D_", "F_")]
    return same_k and all(lens is not None and np.allclose(m, lens.coefficients, rtol=1e-9, atol=1e-12) for m in lenses)


def _is_rigid(matrix: Float[np.ndarray, "3 columns"]) -> bool:
    R = matrix[:, :3]
    return bool(np.abs(R @ R.T - np.eye(3)).max() < 1e-6 and np.linalg.det(R) > 0)
