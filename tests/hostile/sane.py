"""Whether a dataset could come from a warehouse: bounds of this module's own, read without the package's readers."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np

_FARTHEST = 500.0
"""Nothing is farther from the origin of a hall (m)."""
_SINKS = 0.05
"""A label may reach that far below the floor (m)."""
_CAMERA_HEIGHT = (0.02, 30.0)
_BRIGHTEST = 2e5
"""Direct sun (lux)."""
_LEAST_CONTRAST = 1.0
"""Standard deviation of the grey values of an image that shows something."""


def dataset_problem(root: Path) -> str | None:
    """Return the first thing in a dataset that cannot be, if there is one; ``validate`` has looked at its files."""
    sizes = {int(key): np.array(item["size"]) for key, item in json.loads((root / "objects.json").read_bytes()).items()}
    records = {path: json.loads(path.read_bytes()) for path in sorted((root / "scenes").glob("*.json"))}
    found = [f"{path.name}: {problem}" for path, record in records.items() for problem in _problems(record, sizes)]
    images = sorted(root.glob("kitti/t*ing/image_2/*.png"))
    return next(iter([*found, *filter(None, map(image_problem, images))]), None)


def _problems(record: Any, sizes: dict[int, np.ndarray]) -> Iterator[str]:
    walls = []
    for item in record["objects"]:
        T, name = np.array(item["T_world_object"]), f"{item['class_name']} {item['instance_id']}"
        if not np.abs(T[:3, 3]).max() < _FARTHEST:
            yield f"{name} is at {T[:3, 3].round(1).tolist()} m"
        elif item["obj_id"] in sizes and T[2, 3] - np.abs(T[2, :3]) @ sizes[item["obj_id"]] / 2 < -_SINKS:
            yield f"{name} reaches below the floor"
        if item["class_name"] == "wall":
            walls.append(T[:2, 3])
    for number, view in enumerate(record["observations"]):
        at, lux = np.array(view["T_world_camera"])[:3, 3], view["conditions"]["floor_lux"]
        if not _CAMERA_HEIGHT[0] <= at[2] <= _CAMERA_HEIGHT[1]:
            yield f"camera {number} is at {at.round(2).tolist()} m"
        elif len(walls) >= 3 and not ((at[:2] >= np.min(walls, 0)) & (at[:2] <= np.max(walls, 0))).all():
            yield f"camera {number} is outside the hall, at {at.round(1).tolist()} m"
        if lux is not None and not 0.0 <= lux <= _BRIGHTEST:
            yield f"the floor of observation {number} has {lux} lux"
    for light in record["lights"]:
        if not (0.0 <= light["intensity"] < 1e9 and np.abs(light["position"]).max() < _FARTHEST):
            yield f"a light of {light['intensity']} cd at {light['position']}"
    if not 0.0 < record["exposure"] < 1e9:
        yield f"the exposure is {record['exposure']}"


def image_problem(path: Path) -> str | None:
    """Return what is wrong with a colour image, if anything: undecodable, or one even colour."""
    image = cv2.imread(str(path), cv2.IMREAD_COLOR) if path.is_file() else None
    if image is None:
        return f"{path.name} is no image"
    return f"{path.name} is blank: all about {image.mean():.0f} of 255" if image.std() < _LEAST_CONTRAST else None
