"""The valid things that mutations begin with, made by the commands themselves."""

import json
import shutil
from contextlib import closing
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import trimesh
import yaml

from tests.hostile.case import Case
from tests.hostile.worker import Worker

BASES = Path(__file__).parent / "bases"
RACK = BASES / "rack.yaml"
ESTIMATOR = "rectangle-fit"
"""Needs no training, and is quick."""
FEW = ("--max-steps", "2", "--batch", "2", "--size", "nano", "--threads", "1", "--cache", "none")
CRATE = {
    "name": "crate",
    "class_name": "crate",
    "obj_id": 1234,
    "file": "crate.obj",
    "scale": 1.0,
    "up": "z",
    "mass": 4.0,
    "material": "truck_grey",
    "materials": {"crate": "rubber"},
    "symmetry": {"axis": "z", "count": 2},
    "collision": [{"size": [0.4, 0.3, 0.2], "centre": [0.0, 0.0, 0.0]}],
}


@dataclass(frozen=True)
class Stock:
    """A folder of valid recipes, datasets, a run, predictions and scores."""

    root: Path
    every: int = 1
    """Of all mutations, every how many are made at all: to make all takes longer than to try a few."""

    @property
    def data(self) -> Path:
        """A dataset of three small scenes, one a split, in four formats."""
        return self.root / "rack"

    @property
    def poses(self) -> Path:
        """The ground truth of the test split as a pose CSV."""
        return self.root / "gt" / "poses.csv"

    @cached_property
    def scores(self) -> dict[str, Any]:
        """What evaluate says of the ground truth."""
        return json.loads((self.root / "scores" / "scores.json").read_text(encoding="utf-8"))

    def copy(self, name: str, folder: Path, place: str) -> Path:
        """Link a part of the stock into a case's folder; a file must be replaced, never written to."""
        source, target = self.root / name, folder / place
        if source.is_dir():
            shutil.copytree(source, target, copy_function=lambda one, other: Path(other).hardlink_to(one))
        else:
            target.hardlink_to(source)
        return target


def make_stock(root: Path, whole: bool) -> Stock:
    """Make the stock in ``root``; without a run and the dataset of a rig unless it shall be whole."""
    stock = Stock(root, 1 if whole else 29)
    for name in ("gt", "predicted", "found"):
        (root / name).mkdir(parents=True)
    for ending in ("obj", "ply", "glb"):
        trimesh.creation.box(extents=(0.4, 0.3, 0.2)).export(root / f"crate.{ending}")
    (root / "crate.yaml").write_text(yaml.safe_dump(CRATE, sort_keys=False), encoding="utf-8")
    data = ("--data", str(stock.data))
    formats = ("--formats", "kitti", "bop", "coco", "yolo")
    generate = ("generate", str(RACK), "--out", str(stock.data), "--workers", "1", *formats)
    predict = ("predict", ESTIMATOR, *data, "--out", str(root / "predicted" / "poses.csv"))
    evaluate = ("evaluate", str(stock.poses), *data, "--out", str(root / "scores"))
    more = (
        ("generate", str(BASES / "lanes.yaml"), "--out", str(root / "lanes"), "--workers", "1"),
        ("train", "densefusion-pointcloud", *data, "--out", str(root / "run"), *FEW),
        ("predict", str(root / "run"), *data, "--out", str(root / "run.csv")),
    )
    with closing(Worker(root / "worker")) as worker:
        _do(worker, generate)
        _write_labels(stock)
        for step in (predict, evaluate, *(more if whole else ())):
            _do(worker, step)
    return stock


def _do(worker: Worker, step: tuple[str, ...]) -> None:
    verdict = worker.try_case(Case("stock", "valid", "none", (step,), expect="accept"))
    assert verdict.label == "correct", f"warehouse-sim {' '.join(step)}: {verdict.reason}"


def _write_labels(stock: Stock) -> None:
    """Write the labels of the test split as a BOP pose CSV and as COCO's results, from the files alone."""
    lines = ["scene_id,im_id,obj_id,score,R,t,time"]
    for table in sorted(stock.data.glob("bop/test/*/scene_gt.json")):
        for image, labels in json.loads(table.read_text(encoding="utf-8")).items():
            for label in labels:
                R, t = (" ".join(map(repr, label[key])) for key in ("cam_R_m2c", "cam_t_m2c"))
                lines.append(f"{int(table.parent.name)},{image},{label['obj_id']},1.0,{R},{t},0.05")
    stock.poses.write_text("\n".join(lines) + "\n", encoding="ascii")
    labels = json.loads((stock.data / "coco/annotations/instances_test.json").read_bytes())["annotations"]
    keys = ("image_id", "category_id", "bbox", "segmentation")
    rows = [{key: row[key] for key in keys} | {"score": 0.9} for row in labels]
    (stock.root / "found" / "found.json").write_text(json.dumps(rows), encoding="ascii")
