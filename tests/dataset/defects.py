"""Ways to break a copy of the toy dataset, one defect a function."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np

BOP = Path("bop/train/000000")
KITTI = Path("kitti/training")


def edit_json(file: Path | str, change: Callable) -> Callable[[Path], None]:
    def defect(root: Path) -> None:
        data = json.loads((root / file).read_text())
        change(data)
        (root / file).write_text(json.dumps(data))

    return defect


def runs_of(change: Callable) -> Callable[[Path], None]:
    """Change the run lengths of the first annotation."""

    def defect(data: dict) -> None:
        runs = data["annotations"][0]["segmentation"]
        runs["counts"] = change(runs["counts"])

    return edit_json(BOP / "scene_gt_coco.json", defect)


def flat(key: str, **values: Any) -> Callable[[dict], None]:
    """Set values of one entry."""
    return lambda data: data[key].update(values)


def pockets_of(size: list[float]) -> Callable[[Path], None]:
    """Give all pockets another size."""
    return edit_json("objects.json", lambda data: [pocket.update(size=size) for pocket in data["1"]["pockets"]])


def edit_text(file: Path | str, old: str, new: str) -> Callable[[Path], None]:
    def defect(root: Path) -> None:
        text = (root / file).read_text()
        assert old in text
        (root / file).write_text(text.replace(old, new, 1))

    return defect


def edit_image(file: Path | str, change: Callable) -> Callable[[Path], None]:
    def defect(root: Path) -> None:
        image = cv2.imread(str(root / file), cv2.IMREAD_UNCHANGED)
        # A new file: the old one may be shared with the other format.
        (root / file).unlink()
        cv2.imwrite(str(root / file), change(image))

    return defect


def edit_points(file: Path | str, dtype: str, change: Callable) -> Callable[[Path], None]:
    def defect(root: Path) -> None:
        (root / file).write_bytes(change(np.fromfile(root / file, dtype=dtype)).astype(dtype).tobytes())

    return defect


def remove(file: Path | str) -> Callable[[Path], None]:
    return lambda root: (root / file).unlink()


def copy(source: Path | str, target: Path | str) -> Callable[[Path], None]:
    return lambda root: shutil.copy(root / source, root / target)


def shift(values: list[float], step: float) -> None:
    values[0] += step


def drop_last(rows: list) -> None:
    rows.pop()


def black(image: np.ndarray) -> np.ndarray:
    return np.zeros_like(image)


def set_pixel(value: int) -> Callable[[np.ndarray], np.ndarray]:
    def change(image: np.ndarray) -> np.ndarray:
        image[2, 3] = value
        return image

    return change


def upside_down(beams: np.ndarray) -> np.ndarray:
    beams = beams.copy()
    beams[::2] = 23 - beams[::2]
    return beams


def turn_symmetry(entry: dict) -> None:
    c, s = np.cos(1.0), np.sin(1.0)
    entry["symmetries"][1][:2] = [[c, -s, 0.0, 0.0], [s, c, 0.0, 0.0]]
