"""Ways to break a copy of the toy dataset, one defect a function."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path

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


def edit_runs(change: Callable) -> Callable[[Path], None]:
    """Change the run lengths of the first annotation."""

    def defect(data: dict) -> None:
        runs = data["annotations"][0]["segmentation"]
        runs["counts"] = change(runs["counts"])

    return edit_json(BOP / "scene_gt_coco.json", defect)


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


def move_pose(mm: float) -> Callable[[Path], None]:
    """Shift a pose everywhere, so that only pixels can tell."""

    def defect(root: Path) -> None:
        edit_json(BOP / "scene_gt.json", lambda data: shift(data["0"][1]["cam_t_m2c"], mm))(root)
        camera = np.array(json.loads((root / "scenes/000000.json").read_text())["observations"][0]["T_world_camera"])
        step = camera[:3, 0] * mm / 1000

        def shift_record(data: dict) -> None:
            T = next(item for item in data["objects"] if item["instance_id"] == 11)["T_world_object"]
            for axis in range(3):
                T[axis][3] += step[axis]

        edit_json("scenes/000000.json", shift_record)(root)

    return defect


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


def flip(file: Path | str, place: int, bit: int) -> Callable[[Path], None]:
    """Change one bit of a byte."""

    def defect(root: Path) -> None:
        content = bytearray((root / file).read_bytes())
        content[place] ^= 1 << bit
        # A new file: the old one may be shared with the other format.
        (root / file).unlink()
        (root / file).write_bytes(content)

    return defect


def quarter_turns(root: Path) -> None:
    """Claim everywhere that an oblong pallet looks the same after a quarter turn."""
    turns = [[[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]] for c, s in ((1, 0), (0, 1), (-1, 0), (0, -1))]
    edit_json("objects.json", lambda d: d["1"].update(symmetries=turns))(root)
    flat = [np.ravel(turn).tolist() for turn in turns[1:]]
    for kind in ("models", "models_eval"):
        edit_json(f"bop/{kind}/models_info.json", lambda d: d["1"].update(symmetries_discrete=flat))(root)


def blank_line(root: Path) -> None:
    with open(root / KITTI / "label_2/000000.txt", "a") as file:
        file.write("\n")


def turn_symmetry(entry: dict) -> None:
    c, s = np.cos(1.0), np.sin(1.0)
    entry["symmetries"][1][:2] = [[c, -s, 0.0, 0.0], [s, c, 0.0, 0.0]]
