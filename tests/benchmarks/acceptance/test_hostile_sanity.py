"""The bounds of the judge: a dataset that could be is passed, each impossible one is named."""

import json
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from benchmarks.acceptance.hostile.sane_dataset import dataset_problem
from benchmarks.acceptance.hostile.sane_image import image_problem

I4 = np.eye(4).tolist()


def at(x: float, y: float, z: float) -> list:
    T = np.eye(4)
    T[:3, 3] = x, y, z
    return T.tolist()


def record() -> dict:
    walls = [(0.0, 10.0, 2.0), (0.0, -10.0, 2.0), (10.0, 0.0, 2.0), (-10.0, 0.0, 2.0)]
    objects = [
        {"instance_id": i + 2, "class_name": "wall", "obj_id": 202, "T_world_object": at(*place)}
        for i, place in enumerate(walls)
    ]
    pallet = {"instance_id": 1, "class_name": "pallet", "obj_id": 1, "T_world_object": at(1.0, 1.0, 0.072)}
    return {
        "objects": [pallet, *objects],
        "observations": [{"T_world_camera": at(0.0, 0.0, 1.5), "conditions": {"floor_lux": 200.0}}],
        "lights": [{"intensity": 1000.0, "position": [0.0, 0.0, 6.0]}],
        "exposure": 0.01,
    }


def write(root: Path, scene: dict, cloud: np.ndarray, label: str, rgb: np.ndarray, depth: np.ndarray) -> None:
    camera = {"width": 64, "height": 48}
    objects = {"1": {"size": [1.2, 0.8, 0.144], "diameter": 1.449}}
    texts = {
        "manifest.json": json.dumps({"recipe": {"sensors": {"camera": camera}}}),
        "objects.json": json.dumps(objects),
        "scenes/000000.json": json.dumps(scene),
        "kitti/training/label_2/000000.txt": label,
    }
    for name, text in texts.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text, encoding="ascii")
    for name, image in (("kitti/training/image_2", rgb), ("bop/train/000000/depth", depth)):
        (root / name).mkdir(parents=True)
        cv2.imwrite(str(root / name / "000000.png"), image)
    (root / "kitti/training/velodyne").mkdir(parents=True)
    cloud.astype("<f4").tofile(root / "kitti/training/velodyne/000000.bin")


def parts() -> dict:
    rng = np.random.default_rng(0)
    return {
        "scene": record(),
        "cloud": np.ones((10, 4)),
        "label": "pallet 0.0 0 0.1 1 2 3 4 0.144 0.8 1.2 1.0 1.4 4.0 0.3\n",
        "rgb": rng.integers(0, 255, (48, 64, 3), dtype=np.uint8),
        "depth": np.full((48, 64), 3000, np.uint16),
    }


def test_what_could_be_is_passed(tmp_path: Path) -> None:
    write(tmp_path, **parts())
    assert dataset_problem(tmp_path) is None


def change(key: str, *path: object) -> Callable[[dict, object], None]:
    def put(made: dict, value: object) -> None:
        target = made[key]
        for step in path[:-1]:
            target = target[step]
        target[path[-1]] = value

    return put


@pytest.mark.parametrize(
    ("put", "value", "said"),
    [
        (change("scene", "objects", 0, "T_world_object"), at(1.0, 1.0, -0.3), "below the floor"),
        (change("scene", "objects", 0, "T_world_object"), at(1e6, 1.0, 0.1), "is at"),
        (change("scene", "objects", 0, "T_world_object"), (2 * np.eye(4)).tolist(), "no pose"),
        (change("scene", "observations", 0, "T_world_camera"), at(0.0, 0.0, -1.0), "above the floor"),
        (change("scene", "observations", 0, "T_world_camera"), at(30.0, 0.0, 1.5), "outside the hall"),
        (change("scene", "observations", 0, "conditions"), {"floor_lux": 1e9}, "lux"),
        (change("scene", "lights", 0, "intensity"), -1.0, "a light"),
        (change("scene", "exposure"), 0.0, "exposure"),
        (change("cloud", 3, 0), np.nan, "not finite"),
        (change("cloud", 3, 0), 1e7, "m away"),
        (change("depth", ...), 0, "no reading"),
        (change("rgb", ...), 0, "blank"),
    ],
)
def test_the_impossible_is_named(tmp_path: Path, put: Callable, value: object, said: str) -> None:
    made = parts()
    put(made, value)
    write(tmp_path, **made)
    assert said in (dataset_problem(tmp_path) or "")


@pytest.mark.parametrize(("old", "new", "said"), [("1.2", "1200.0", "an object of"), ("4.0 0.3", "nan 0.3", "finite")])
def test_impossible_labels_are_named(tmp_path: Path, old: str, new: str, said: str) -> None:
    made = parts()
    write(tmp_path, **{**made, "label": made["label"].replace(old, new)})
    assert said in (dataset_problem(tmp_path) or "")


def test_a_sheet_must_be_an_image(tmp_path: Path) -> None:
    path = tmp_path / "sheet.png"
    assert image_problem(path) == "was not written"
    path.write_bytes(b"no image")
    assert image_problem(path) == "cannot be decoded"
