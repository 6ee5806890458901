"""Checks of the BOP folder's files, tables and models."""

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from warehouse_sim.dataset.checks.findings import Findings, compare_names
from warehouse_sim.dataset.checks.labels import VISIBLE_ENOUGH, agree_with_record
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.files.json_file import read_json, read_table
from warehouse_sim.dataset.files.plain import read_lens, take, take_if_given, take_numbers
from warehouse_sim.dataset.formats.bop import (
    BopLayout,
    bop_layout,
    exact_kinds,
    image_kinds,
    mask_kinds,
    table_names,
)
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.dataset.split import SPLITS
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Lens, same_lens

_KEYS = ("fx", "fy", "cx", "cy")


def cameras(subject: Subject) -> Findings:
    """Hold camera.json and each row of scene_camera.json against each other and the recipe."""
    bop = bop_layout(subject.root)
    path, recipe_camera = bop.camera, subject.manifest.contents.camera
    data, where = read_json(path), str(path)
    values = {key: take(data, key, float, where) for key in (*_KEYS, "depth_scale")}
    size_wh = take(data, "width", int, where), take(data, "height", int, where)
    lens = read_lens(data, where)
    findings, count = Findings(), 0
    if recipe_camera is not None:
        same = size_wh == (recipe_camera.width, recipe_camera.height)
        findings.require(same and _same(values, lens, recipe_camera.make()), f"{path}: is not the camera of the recipe")
    for image in subject.images():
        table = bop.scene(image.split, image.scene_id).table("camera")
        same = _same(values, lens, image.camera) and image.depth_scale == values["depth_scale"]
        findings.require(same, f"{table}: {image.image_id}: is not the camera of {path}")
        count += 1
    findings.examined = f"{count} cameras, those of camera.json and the recipe"
    return findings


def _same(values: dict[str, float], lens: Lens | None, camera: PinholeCamera) -> bool:
    same = np.allclose([values[key] for key in _KEYS], [getattr(camera, key) for key in _KEYS], rtol=1e-9)
    return bool(same) and same_lens(lens, camera.distortion)


_MILLIMETRE_DIGITS = 1e-3


def models(subject: Subject) -> Findings:
    """Sizes, diameters and symmetries of both tables are those of the meshes and of objects.json."""
    findings = Findings(f"{len(subject.objects)} models of two kinds")
    for info in subject.objects.values():
        _agree(findings, bop_layout(subject.root), info)
    return findings


def _agree(findings: Findings, bop: BopLayout, info: ObjectInfo) -> None:
    for kind, mesh in (("models", info.mesh()), ("models_eval", info.metric_mesh())):
        path = bop.models_info(kind)
        where = f"{path}: {info.obj_id}"
        entry = take(read_json(path), str(info.obj_id), dict, str(path))
        low = np.array([take(entry, f"min_{axis}", float, where) for axis in "xyz"])
        size = np.array([take(entry, f"size_{axis}", float, where) for axis in "xyz"])
        points_mm = mesh.vertices * 1000.0
        same_box = np.abs([low - points_mm.min(axis=0), low + size - points_mm.max(axis=0)]).max() < _MILLIMETRE_DIGITS
        findings.require(bool(same_box), f"{where}: min and size are not those of the mesh")
        largest = take(entry, "diameter", float, where)
        same_diameter = abs(largest - info.diameter * 1000.0) < _MILLIMETRE_DIGITS
        findings.require(same_diameter, f"{where}: diameter {largest:.4f} mm is not that of objects.json")
        rows = take_if_given(entry, "symmetries_discrete", list, where) or []
        motions = {str(i): row for i, row in enumerate(rows)}
        numbers = [take_numbers(motions, key, 16, f"{where}: symmetries_discrete") for key in motions]
        listed = np.reshape(numbers, (-1, 4, 4))
        listed[:, :3, 3] /= 1000.0
        axes = [
            take_numbers(axis, "axis", 3, f"{where}: symmetries_continuous")
            for axis in take_if_given(entry, "symmetries_continuous", list, where) or []
        ]
        same_symmetry = _is_group(info, listed, axes)
        findings.require(
            same_symmetry, f"{where}: symmetries_discrete or symmetries_continuous differ from objects.json"
        )


def _is_group(info: ObjectInfo, discrete: Float[np.ndarray, "n 4 4"], axes: Sequence[Float[np.ndarray, " 3"]]) -> bool:
    """Say whether the motions of objects.json are those that are listed, each up to a turn about the axis if one is."""
    motions = info.symmetry.transforms
    if not axes:
        return discrete.shape == motions[1:].shape and np.allclose(discrete, motions[1:], atol=1e-9)
    if len(axes) > 1:
        return False
    along = np.append(axes[0], 0.0)
    listed = np.stack([np.eye(4), *discrete])
    # D^-1 T turns about the axis if both bring it to the same place.
    ends = np.array([[np.allclose(D @ along, T @ along, atol=1e-9) for D in listed] for T in motions])
    return bool((ends.sum(axis=1) == 1).all() and len(set(ends.sum(axis=0).tolist())) == 1)


def files(subject: Subject) -> Findings:
    """Each split holds its scenes and no other; each scene its images, masks and tables and nothing else."""
    findings, count = Findings(), 0
    for split in SPLITS:
        scene_names = {f"{index:06d}" for index in subject.manifest.splits[split]}
        folder = bop_layout(subject.root).root / split
        if scene_names or folder.exists():
            compare_names(findings, folder, scene_names, "scene")
    images = {f"{index:06d}.png" for index in range(subject.manifest.observations_per_scene)}
    contents = subject.manifest.contents
    tables = {f"scene_{name}.json" for name in table_names(contents)}
    channels, kinds = [*image_kinds(contents), *exact_kinds(contents)], mask_kinds(contents)
    for split, scene in subject.scenes():
        layout = bop_layout(subject.root).scene(split, scene)
        compare_names(findings, layout.root, {*channels, *kinds} | tables)
        poses = read_table(layout.table("gt"))
        masks = {f"{image_id:06d}_{i:06d}.png" for image_id, row in poses.items() for i in range(_count(row))}
        for name, expected in (*((name, images) for name in channels), *((name, masks) for name in kinds)):
            compare_names(findings, layout.root / name, expected)
            count += len(expected)
    findings.examined = f"{count} images and masks"
    return findings


def tables(subject: Subject) -> Findings:
    """Compare the tables with the scene records: the same images, objects, cameras and rigid poses."""
    findings, count = Findings(), 0
    wanted = set(range(subject.manifest.observations_per_scene))
    for split, scene in subject.scenes():
        path = bop_layout(subject.root).scene(split, scene).table("camera")
        listed = set(read_table(path))
        findings.require(listed == wanted, f"{path}: lists images {sorted(listed)}, the manifest {sorted(wanted)}")
    for image in subject.images():
        count += len(image.targets)
        path = bop_layout(subject.root).scene(image.split, image.scene_id).table("gt")
        agree_with_record(findings, subject, image, f"{path}: {image.image_id}")
    findings.examined = f"{count} poses, rigid and equal to the scene records"
    return findings


def coco(subject: Subject) -> Findings:
    """scene_gt_coco.json holds the same objects, areas and boxes as scene_gt and scene_gt_info, in the same order."""
    findings, count = Findings(), 0
    for split in SPLITS:
        by_scene: dict[int, list[ImageRecord]] = {}
        for image in subject.readable.images(split):
            by_scene.setdefault(image.scene_id, []).append(image)
        for scene, images in by_scene.items():
            path = bop_layout(subject.root).scene(split, scene).table("gt_coco")
            count += _coco_agrees(findings, path, images)
    findings.examined = f"{count} annotations"
    return findings


def targets(subject: Subject) -> Findings:
    """Compare the target files with what is visible enough in the test split."""
    findings = Findings()
    rows19, rows24 = [], []
    for image in subject.readable.images("test"):
        key = {"scene_id": image.scene_id, "im_id": image.image_id}
        counts = Counter(target.obj_id for target in image.targets if target.visible_fraction >= VISIBLE_ENOUGH)
        rows19 += [{**key, "obj_id": obj_id, "inst_count": counts[obj_id]} for obj_id in sorted(counts)]
        rows24.append(key)
    for year, rows in ((2019, rows19), (2024, rows24)):
        path = bop_layout(subject.root).targets(year)
        findings.require(read_json(path) == rows, f"{path}: does not list what the test split shows")
    findings.examined = f"{len(rows19)} targets in {len(rows24)} test images"
    return findings


def _count(row: Any) -> int:
    """Return the number of poses of an image; what is no list is reported where it is read."""
    return len(row) if isinstance(row, list) else 0


def _coco_agrees(findings: Findings, path: Path, images: list[ImageRecord]) -> int:
    data, where = read_json(path), str(path)
    expected_images = [
        {
            "id": image.image_id,
            "file_name": f"rgb/{image.image_id:06d}.png",
            "width": image.camera.width,
            "height": image.camera.height,
        }
        for image in images
    ]
    findings.require(take(data, "images", list, where) == expected_images, f"{where}: images differ from scene_camera")
    annotations = take(data, "annotations", list, where)
    pairs = [(image, target) for image in images for target in image.targets]
    if not findings.require(
        len(annotations) == len(pairs), f"{where}: {len(annotations)} annotations, {len(pairs)} poses"
    ):
        return 0
    for i, (annotation, (image, target)) in enumerate(zip(annotations, pairs, strict=True)):
        left, top, right, bottom = target.box_amodal_xyxy
        expected = {
            "id": i + 1,
            "image_id": image.image_id,
            "category_id": target.obj_id,
            "area": target.pixels_visible,
            "bbox": [left, top, right - left + 1, bottom - top + 1],
            "iscrowd": 0,
            "ignore": target.visible_fraction < VISIBLE_ENOUGH,
        }
        for key, value in expected.items():
            found = annotation.get(key) if isinstance(annotation, dict) else None
            findings.require(found == value, f"{where}: annotation {i + 1}: {key} is {found!r}, not {value!r}")
    return len(annotations)
