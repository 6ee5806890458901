"""Checks of the KITTI folder: files, lists, labels, calibration, points."""

import math
from pathlib import Path

import numpy as np
from jaxtyping import Float, Float32, Int32

from warehouse_sim.dataset.checks.clean import NOT_ITS_TRUTH, reads
from warehouse_sim.dataset.checks.subject import Findings, Subject, compare_names
from warehouse_sim.dataset.image_io import decode_depth, decode_rgb, png_size_wh
from warehouse_sim.dataset.layout import kitti_kinds
from warehouse_sim.dataset.scene_record import RecordedObject
from warehouse_sim.dataset.split import SPLITS, Split
from warehouse_sim.dataset.writers.kitti_calib import CALIB_KEYS, parse_calib
from warehouse_sim.dataset.writers.kitti_label import KittiLabel, parse_label
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.pose import invert, make_transform, transform_points

_SAME_PLACE = 1e-5
# Range noise puts points a little outside. Where a beam meets an edge, its point can lie between two surfaces: a few
# points a sweep and object, more of them the more points it has.
_BOX_MARGIN = 0.1
# A beam that meets two surfaces reads a range between them: some at every edge of an object, few over all. What is seen
# through a gap has little else.
_MIXED_POINTS, _MIXED_SHARE, _MIXED_SHARE_OVERALL = 8, 0.1, 0.01


def files(subject: Subject) -> Findings:
    """Each folder holds the frames of its splits and nothing else, and the lists name them."""
    findings, kinds = Findings(), kitti_kinds(subject.manifest.recipe)
    by_split: dict[Split, set[int]] = {split: set() for split in SPLITS}
    for split, _, _, frame in subject.frames():
        by_split[split].add(frame)
    folders: dict[Split, set[int]] = {"train": by_split["train"] | by_split["val"], "test": by_split["test"]}
    for split, frames in folders.items():
        for kind, ending in kinds.items():
            names = {f"{frame:06d}.{ending}" for frame in frames}
            compare_names(findings, subject.kitti.folder(split) / kind, names)
    sets: dict[str, set[int]] = {name: by_split[name] for name in SPLITS} | {
        "trainval": by_split["train"] | by_split["val"]
    }
    for name, frames in sets.items():
        path = subject.kitti.image_set(name)
        listed = read_text(path).split("\n")[:-1]
        findings.require(listed == [f"{frame:06d}" for frame in sorted(frames)], f"{path}: is not the manifest's split")
    findings.examined = f"{sum(map(len, by_split.values()))} frames, {len(kinds)} files each"
    return findings


def labels(subject: Subject) -> Findings:
    """Every row parses strictly, has plausible values, and stands where the scene record has such an object."""
    findings, count = Findings(), 0
    for split, scene, observation, frame in subject.frames():
        path = subject.kitti.file(split, "label_2", frame)
        size_wh = png_size_wh(subject.kitti.file(split, "image_2", frame))
        for number, label in enumerate(read_labels(subject, split, frame), start=1):
            where = f"{path}:{number}"
            _plausible(findings, label, size_wh, where)
            item = recorded_object(subject, scene, observation, label)
            if findings.require(item is not None, f"{where}: the scene record has no {label.type} there") and item:
                length, breadth, height = subject.info(item.obj_id).size
                same_size = np.abs(np.subtract(label.size_hwl, (height, breadth, length))).max() < _SAME_PLACE
                findings.require(bool(same_size), f"{where}: size {label.size_hwl} is not that of object {item.obj_id}")
            count += 1
    findings.examined = f"{count} labels of 15 fields"
    return findings


def calib(subject: Subject) -> Findings:
    """Calib files have seven lines, rigid, no rotation hidden in P2, and the recipe's lens; planes are the floor."""
    findings, count = Findings(), 0
    for split, scene, observation, frame in subject.frames():
        path = subject.kitti.file(split, "calib", frame)
        matrices = parse_calib(read_text(path), str(path))
        findings.require(bool((matrices["P2"][2] == [0, 0, 1, 0]).all()), f"{path}: P2 must end in 0 0 1 0")
        findings.require(_is_pair(matrices, subject), f"{path}: P3 must be P2 moved along x by the recipe's baseline")
        findings.require(_has_lens(matrices, subject), f"{path}: K_0x must be that of P2, D_0x the recipe's distortion")
        for key in ("R0_rect", "Tr_velo_to_cam", "Tr_imu_to_velo"):
            R = matrices[key][:, :3]
            rigid = np.abs(R @ R.T - np.eye(3)).max() < 1e-6 and np.linalg.det(R) > 0
            findings.require(bool(rigid), f"{path}: {key} is not a rotation")
        plane_path = subject.kitti.file(split, "planes", frame)
        T_camera_world = invert(subject.T_world_camera(scene, observation))
        expected = np.array([*T_camera_world[:3, 2], -T_camera_world[:3, 2] @ T_camera_world[:3, 3]])
        findings.require(
            bool(np.abs(_plane(plane_path) - expected).max() < _SAME_PLACE), f"{plane_path}: is not the floor's plane"
        )
        count += 1
    findings.examined = f"{count} files of 7 lines and as many planes"
    return findings


def points(subject: Subject) -> Findings:
    """LiDAR points that carry a labelled object's id lie in that label's 3D box, but for those of mixed beams."""
    findings, in_boxes, outside, frames = Findings(), 0, 0, 0
    for split, scene, observation, frame in subject.frames():
        frames += 1
        path = subject.kitti.file(split, "velodyne", frame)
        cloud, ids = read_points(subject, split, frame)
        matrices = parse_calib(read_text(subject.kitti.file(split, "calib", frame)), str(path))
        T_camera_lidar = make_transform(matrices["Tr_velo_to_cam"][:, :3], matrices["Tr_velo_to_cam"][:, 3])
        for label in read_labels(subject, split, frame):
            item = recorded_object(subject, scene, observation, label)
            if item is None:
                continue
            own = cloud[ids == item.instance_id, :3].astype(float)
            T_box_lidar = invert(label.T_camera_object()) @ T_camera_lidar
            height, breadth, length = label.size_hwl
            limits = np.array([length, breadth, height]) / 2.0 + _BOX_MARGIN
            inside = (np.abs(transform_points(T_box_lidar, own)) <= limits).all(axis=1)
            in_boxes += len(own)
            outside += int((~inside).sum())
            findings.require(
                (~inside).sum() <= _MIXED_POINTS + _MIXED_SHARE * len(own),
                f"{path}: {(~inside).sum()} of {len(own)} points of object {item.instance_id} are outside its box",
            )
    findings.require(
        outside <= _MIXED_POINTS + _MIXED_SHARE_OVERALL * in_boxes,
        f"{outside} of {in_boxes} points of labelled objects are outside their boxes",
    )
    findings.examined = f"{in_boxes} points of labelled objects in {frames} sweeps"
    return findings


def images(subject: Subject) -> Findings:
    """Read every colour and depth image: one size, and not empty.

    With BOP files in the dataset the colour images are not decoded a second time: another check compares their bytes.
    """
    findings, count, kinds = Findings(), 0, kitti_kinds(subject.manifest.recipe)
    for split, _, _, frame in subject.frames():
        rgb_path, depth_path = (subject.kitti.file(split, kind, frame) for kind in ("image_2", "depth_2"))
        steps, size_wh = decode_depth(depth_path), png_size_wh(rgb_path)
        findings.require(
            steps.shape == size_wh[::-1], f"{depth_path}: is {steps.shape}, its image {size_wh[::-1]} (h, w)"
        )
        findings.require(bool(steps.any()), f"{depth_path}: holds nothing but zeros")
        if "depth_clean_2" in kinds:
            clean_path = subject.kitti.file(split, "depth_clean_2", frame)
            findings.require(reads(decode_depth(clean_path), steps), f"{clean_path}: {NOT_ITS_TRUTH}")
            clean_path = subject.kitti.file(split, "image_clean_2", frame)
            findings.require(png_size_wh(clean_path) == size_wh, f"{clean_path}: is not as large as image_2")
        if "image_3" in kinds:
            _right_image(findings, subject, split, frame, size_wh)
        if "bop" not in subject.manifest.formats:
            findings.require(bool(decode_rgb(rgb_path).any()), f"{rgb_path}: holds nothing but zeros")
        count += 2
    findings.examined = f"{count} images"
    return findings


def _right_image(findings: Findings, subject: Subject, split: Split, frame: int, size_wh: tuple[int, int]) -> None:
    rgb_path, disparity_path = (subject.kitti.file(split, kind, frame) for kind in ("image_3", "disp_occ"))
    image, steps = decode_rgb(rgb_path), decode_depth(disparity_path)
    findings.require(image.shape[1::-1] == size_wh, f"{rgb_path}: is not as large as image_2")
    findings.require(steps.shape == size_wh[::-1], f"{disparity_path}: is not as large as image_2")
    seen_path = subject.kitti.file(split, "disp_noc", frame)
    seen = decode_depth(seen_path)
    part = seen.shape == steps.shape and bool(((seen == 0) | (seen == steps)).all())
    findings.require(part, f"{seen_path}: is no part of disp_occ")
    findings.require(bool(image.any() and steps.any()), f"{rgb_path} or {disparity_path}: holds nothing but zeros")


def read_labels(subject: Subject, split: Split, frame: int) -> list[KittiLabel]:
    """Read a frame's labels; a lone DontCare row is no label.

    Raises:
        DatasetError: The file is missing, empty, has a blank line, or a row that does not parse.
    """
    path = subject.kitti.file(split, "label_2", frame)
    lines = read_text(path).split("\n")
    if len(lines) < 2 or lines[-1]:
        raise DatasetError(f"{path}: at least one row and a line end after the last one are expected")
    rows = [parse_label(line, f"{path}:{number}") for number, line in enumerate(lines[:-1], start=1)]
    labels = [row for row in rows if row is not None]
    if None in rows[: len(labels)]:
        raise DatasetError(f"{path}: DontCare must come last")
    return labels


def read_points(
    subject: Subject, split: Split, frame: int, name: str = "velodyne"
) -> tuple[Float32[np.ndarray, "n 4"], Int32[np.ndarray, " n"]]:
    """Read a sweep, of the LiDAR whose folder is ``name``, and the instance id of each point.

    Raises:
        DatasetError: A file is missing or the two have not the same number of points.
    """
    path, ids_path = (subject.kitti.file(split, kind, frame) for kind in (name, f"{name}_ids"))
    cloud, ids = read_bytes(path), read_bytes(ids_path)
    if len(cloud) % 16 or len(cloud) != 4 * len(ids):
        raise DatasetError(f"{path}: {len(cloud)} bytes of points do not go with {len(ids)} bytes of ids")
    return np.frombuffer(cloud, dtype="<f4").reshape(-1, 4), np.frombuffer(ids, dtype="<i4")


def recorded_object(subject: Subject, scene: int, observation: int, label: KittiLabel) -> RecordedObject | None:
    """Return the object of the scene record whose class and place are those of a label."""
    T_world_camera = subject.T_world_camera(scene, observation)
    centre = transform_points(T_world_camera, label.T_camera_object()[None, :3, 3])[0]
    for item in subject.record(scene).objects:
        if item.class_name == label.type and np.abs(item.T_world_object[:3, 3] - centre).max() < _SAME_PLACE:
            return item
    return None


def _plausible(findings: Findings, label: KittiLabel, size_wh: tuple[int, int], where: str) -> None:
    left, top, right, bottom = label.box_xyxy
    findings.require(
        0 <= left <= right <= size_wh[0] - 1 and 0 <= top <= bottom <= size_wh[1] - 1,
        f"{where}: the 2D box {label.box_xyxy} is not in the image of {size_wh[0]} x {size_wh[1]}",
    )
    findings.require(0.0 <= label.truncated <= 1.0, f"{where}: truncated {label.truncated} is not in 0-1")
    findings.require(label.occluded in (0, 1, 2), f"{where}: occluded {label.occluded} is not 0, 1 or 2")
    x, _, z = label.location
    turn = label.rotation_y - math.atan2(x, z) - label.alpha
    findings.require(
        abs(math.remainder(turn, 2 * math.pi)) < _SAME_PLACE and max(abs(label.alpha), abs(label.rotation_y)) <= 3.1416,
        f"{where}: alpha {label.alpha} and rotation_y {label.rotation_y} do not go together",
    )


def _is_pair(matrices: dict[str, Float[np.ndarray, "rows columns"]], subject: Subject) -> bool:
    """Return whether the right camera is the left one, moved by the recipe's baseline, 0 without a right camera."""
    moved = np.zeros((3, 4))
    moved[0, 3] = -matrices["P2"][0, 0] * (subject.rig.baseline or 0.0)
    return bool(np.abs(matrices["P3"] - matrices["P2"] - moved).max() < _SAME_PLACE)


def _has_lens(matrices: dict[str, Float[np.ndarray, "rows columns"]], subject: Subject) -> bool:
    """Return whether each camera has the lens of the recipe, and no other lines than for that."""
    wanted = subject.rig.distortion
    eyes = ("02",) if subject.rig.baseline is None else ("02", "03")
    if set(matrices) - set(CALIB_KEYS) != {f"{key}_{eye}" for eye in eyes if wanted for key in "KD"}:
        return False
    if wanted is None:
        return True
    lens = wanted.coefficients
    same_k = all(np.abs(matrices[f"K_{eye}"] - matrices["P2"][:, :3]).max() < _SAME_PLACE for eye in eyes)
    return same_k and all(np.allclose(matrices[f"D_{eye}"], lens, rtol=1e-9, atol=1e-12) for eye in eyes)


def _plane(path: Path) -> Float[np.ndarray, " 4"]:
    lines = read_text(path).split("\n")
    try:
        values = np.array([float(word) for word in lines[3].split(" ")])
    except (IndexError, ValueError) as problem:
        raise DatasetError(f"{path}: the fourth line must hold four numbers ({problem})") from problem
    if values.shape != (4,) or len(lines) != 5 or lines[4]:
        raise DatasetError(f"{path}: four lines are expected, the last with four numbers")
    return values


def read_text(path: Path) -> str:
    """Return the content of a text file.

    Raises:
        DatasetError: It cannot be read, or is not ASCII.
    """
    try:
        return read_bytes(path).decode("ascii")
    except UnicodeDecodeError as problem:
        raise DatasetError(f"{path}: holds something else than ASCII text ({problem.reason})") from problem


def read_bytes(path: Path) -> bytes:
    """Return the content of a file.

    Raises:
        DatasetError: It cannot be read.
    """
    try:
        return path.read_bytes()
    except OSError as problem:
        raise DatasetError(f"{path}: cannot be read ({problem.strerror})") from problem
