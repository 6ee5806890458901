"""Whether a dataset could come from a warehouse: bounds of this module's own, read without the product's readers."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.acceptance.hostile.documents import leaves
from benchmarks.acceptance.hostile.sane_image import depth_problem, image_problem

_FARTHEST = 500.0
"""Nothing is farther from the origin of a hall (m)."""
_LARGEST, _SMALLEST = 60.0, 0.005
"""Longest and shortest edge of an object (m)."""
_SINKS = 0.05
"""A label may reach that far below the floor (m)."""
_CAMERA_HEIGHT = (0.02, 30.0)
_BRIGHTEST = 2e5
"""Direct sun (lux)."""
_TEXT_FIELDS = 15


def dataset_problem(root: Path) -> str | None:
    """Return the first thing in a KITTI and BOP dataset that cannot be, if there is one."""
    return next(_problems(root), None)


def _problems(root: Path) -> Iterator[str]:
    manifest, objects = _json(root / "manifest.json"), _json(root / "objects.json")
    yield from _object_problems(objects)
    for path in sorted((root / "scenes").glob("*.json")):
        yield from (f"{path.name}: {problem}" for problem in _record_problems(_json(path), objects))
    for path in sorted(root.rglob("*.json")):
        yield from (f"{path.name}: {where} is {value}" for where, value in _not_finite(_json(path)))
    camera = manifest["recipe"]["sensors"]["camera"]
    for path in sorted((root / "kitti").glob("t*ing/image_2/*.png")):
        problem = image_problem(path, (camera["width"], camera["height"]))
        if problem:
            yield f"{path.name}: {problem}"
    for path in sorted((root / "bop").glob("t*/*/depth/*.png")):
        problem = depth_problem(path, 1000.0)
        if problem:
            yield f"depth of {path.name}: {problem}"
    for path in sorted((root / "kitti").glob("t*ing/label_2/*.txt")):
        yield from (f"{path.name}: {problem}" for problem in _label_problems(path))
    for path in sorted((root / "kitti").glob("t*ing/velodyne/*.bin")):
        problem = _sweep_problem(path)
        if problem:
            yield f"{path.name}: {problem}"


def _json(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))


def _not_finite(data: Any) -> Iterator[tuple[str, float]]:
    for path, value in leaves(data):
        if isinstance(value, float) and not np.isfinite(value):
            yield ".".join(map(str, path)), value


def _object_problems(objects: dict[str, Any]) -> Iterator[str]:
    for number, entry in objects.items():
        size = np.array(entry["size"])
        if not ((size >= _SMALLEST) & (size <= _LARGEST)).all():
            yield f"objects.json: {number} is {size.tolist()} m large"
        if not size.max() * 0.5 <= entry["diameter"] <= np.linalg.norm(size) * 1.001:
            yield f"objects.json: {number} has a diameter of {entry['diameter']} m and a size of {size.tolist()} m"


def _record_problems(record: dict[str, Any], objects: dict[str, Any]) -> Iterator[str]:
    walls = []
    for item in record["objects"]:
        T = np.array(item["T_world_object"])
        name = f"{item['class_name']} {item['instance_id']}"
        if not _is_rigid(T):
            yield f"the pose of {name} is no pose"
        elif np.abs(T[:3, 3]).max() > _FARTHEST:
            yield f"{name} is at {T[:3, 3].round(1).tolist()} m"
        elif str(item["obj_id"]) in objects and _lowest(T, objects[str(item["obj_id"])]["size"]) < -_SINKS:
            yield f"{name} reaches below the floor"
        if item["class_name"] == "wall":
            walls.append(T[:2, 3])
    yield from _view_problems(record, np.array(walls))
    for light in record["lights"]:
        if not (0.0 <= light["intensity"] < 1e9 and np.abs(light["position"]).max() < _FARTHEST):
            yield f"a light of {light['intensity']} cd at {light['position']}"
    if not 0.0 < record["exposure"] < 1e9:
        yield f"the exposure is {record['exposure']}"


def _view_problems(record: dict[str, Any], walls: np.ndarray) -> Iterator[str]:
    for number, view in enumerate(record["observations"]):
        T = np.array(view["T_world_camera"])
        if not _is_rigid(T):
            yield f"the pose of camera {number} is no pose"
            continue
        if not _CAMERA_HEIGHT[0] <= T[2, 3] <= _CAMERA_HEIGHT[1]:
            yield f"camera {number} is {T[2, 3]:.2f} m above the floor"
        if len(walls) >= 3 and not ((T[:2, 3] >= walls.min(axis=0)) & (T[:2, 3] <= walls.max(axis=0))).all():
            yield f"camera {number} is outside the hall, at {T[:2, 3].round(1).tolist()}"
        lux = view["conditions"]["floor_lux"]
        if lux is not None and not 0.0 <= lux <= _BRIGHTEST:
            yield f"the floor of observation {number} has {lux} lux"


def _lowest(T_world_object: np.ndarray, size: list[float]) -> float:
    """Return the height (m) of the lowest corner of an object's box."""
    return float(T_world_object[2, 3] - np.abs(T_world_object[2, :3]) @ (np.array(size) / 2.0))


def _is_rigid(T: np.ndarray) -> bool:
    return bool(
        T.shape == (4, 4)
        and np.isfinite(T).all()
        and np.abs(T[:3, :3] @ T[:3, :3].T - np.eye(3)).max() < 1e-6
        and np.linalg.det(T[:3, :3]) > 0
        and (T[3] == [0, 0, 0, 1]).all()
    )


def _label_problems(path: Path) -> Iterator[str]:
    for line in path.read_text(encoding="ascii").splitlines():
        cells = line.split()
        if cells[0] == "DontCare":
            continue
        if len(cells) != _TEXT_FIELDS:
            yield f"{len(cells)} fields"
            continue
        numbers = np.array(cells[1:], dtype=float)
        if not np.isfinite(numbers).all():
            yield "a field is not finite"
        elif not ((numbers[7:10] >= _SMALLEST) & (numbers[7:10] <= _LARGEST)).all():
            yield f"an object of {numbers[7:10].tolist()} m"
        elif not 0.0 < np.linalg.norm(numbers[10:13]) < _FARTHEST:
            yield f"an object {np.linalg.norm(numbers[10:13]):.1f} m away"


def _sweep_problem(path: Path) -> str | None:
    points = np.fromfile(path, dtype="<f4")
    if points.size == 0 or points.size % 4:
        return f"{points.size} numbers"
    points = points.reshape(-1, 4)
    if not np.isfinite(points).all():
        return "a point is not finite"
    if np.linalg.norm(points[:, :3], axis=1).max() > _FARTHEST:
        return f"a point is {np.linalg.norm(points[:, :3], axis=1).max():.0f} m away"
    return None
