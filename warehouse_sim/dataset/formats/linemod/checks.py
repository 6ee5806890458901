"""Checks of the LINEMOD files: plain YAML and OpenCV open them, the scene records know better."""

from collections import defaultdict
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml

from warehouse_sim.dataset.checks.findings import Findings, NamedCheck
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.files.json_file import read_json
from warehouse_sim.dataset.formats.linemod import LinemodLayout, linemod_layout
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.pose import invert

_SAME_POSE = 1e-6


def frames(subject: Subject) -> Findings:
    """Every frame has its images, is in one list, and has the pose of its object in the scene record."""
    findings, layout = Findings(), linemod_layout(subject.root)
    numbers: dict[int, int] = defaultdict(int)
    tables: dict[int, dict[int, Any]] = {}
    for split, scene in sorted(subject.scenes(), key=lambda item: item[1]):
        for row in read_json(layout.scene(scene)):
            obj_id, observation = row["obj_id"], row["observation"]
            if obj_id not in tables:
                tables[obj_id] = _table(layout.object_folder(obj_id) / "gt.yml")
            frame, where = numbers[obj_id], f"{layout.object_folder(obj_id) / 'gt.yml'}: {numbers[obj_id]}"
            numbers[obj_id] += 1
            listed = (layout.object_folder(obj_id) / f"{split}.txt").read_text().split()
            findings.require(f"{frame:04d}" in listed, f"{where}: is not in {split}.txt")
            label = tables[obj_id].get(frame, [{}])[0]
            item = subject.record(scene).object(label.get("instance_id", 0))
            if not findings.require(item is not None and label.get("obj_id") == obj_id, f"{where}: names no object"):
                continue
            assert item is not None
            T = invert(subject.T_world_camera(scene, observation)) @ item.T_world_object
            R, t_mm = np.reshape(label["cam_R_m2c"], (3, 3)), np.array(label["cam_t_m2c"])
            moved = max(np.abs(R - T[:3, :3]).max(), np.abs(t_mm / 1000.0 - T[:3, 3]).max())
            findings.require(
                bool(moved < _SAME_POSE), f"{where}: the pose differs from the scene record by {moved:.2e}"
            )
            _images(findings, layout, obj_id, frame, label)
            findings.count += 1
    findings.examined = f"{findings.count} frames of {len(tables)} objects"
    return findings


def _table(path: Path) -> dict[int, Any]:
    try:
        found = yaml.load(path.read_bytes(), getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    except (OSError, yaml.YAMLError) as problem:
        raise DatasetError(f"{path}: cannot be read ({problem}); generate the dataset again") from problem
    if not isinstance(found, dict):
        raise DatasetError(f"{path}: is no table; generate the dataset again")
    return found


def _images(findings: Findings, layout: LinemodLayout, obj_id: int, frame: int, label: dict[str, Any]) -> None:
    paths = {kind: layout.image(obj_id, kind, frame) for kind in ("rgb", "depth", "mask")}
    images: dict[str, Any] = {kind: cv2.imread(str(path), cv2.IMREAD_UNCHANGED) for kind, path in paths.items()}
    for kind, image in images.items():
        if not findings.require(image is not None, f"{paths[kind]}: is not a readable image"):
            return
    mask = images["mask"]
    findings.require(mask.shape == images["rgb"].shape, f"{paths['mask']}: is not of the size of the colour image")
    findings.require(images["depth"].dtype == np.uint16, f"{paths['depth']}: has not 16 bits")
    white = int(np.count_nonzero(np.all(mask.reshape(*mask.shape[:2], -1) == 255, axis=2)))
    findings.require(
        white == label["px_count_visib"], f"{paths['mask']}: {white} pixels, not {label['px_count_visib']}"
    )


CHECKS = (NamedCheck("linemod frames", frames),)
