"""The valid things that mutations begin with, made by the commands themselves at the start of a run."""

import json
import os
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
import yaml

from benchmarks.acceptance.hostile.watch import Outcome, Watched

BASES = Path(__file__).parent / "bases"
MODEL = "densefusion-depth"
"""A bundled estimator that is small and sees no colour."""
_SECONDS = 300.0
_CRATE = {
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

    @property
    def data(self) -> Path:
        """A dataset of three small scenes, one a split."""
        return self.root / "rack"

    @property
    def rig_data(self) -> Path:
        """A dataset of a rig with a pair of cameras behind a lens, two LiDARs and clean images."""
        return self.root / "lanes"

    @property
    def run(self) -> Path:
        """A run folder of a few steps."""
        return self.root / "run"

    @property
    def gt(self) -> Path:
        """The test split's true poses as predictions."""
        return self.root / "gt.csv"

    @property
    def predictions(self) -> Path:
        """What the bundled estimator says of the test split."""
        return self.root / "predictions.csv"

    @property
    def scores(self) -> Path:
        """The scores of the true poses."""
        return self.root / "scores"

    def recipe(self, name: str) -> Any:
        """Return a base recipe with every setting spelt out, as the manifest of its dataset has it."""
        return json.loads((self.root / name / "manifest.json").read_text(encoding="utf-8"))["recipe"]

    @cached_property
    def true_scores(self) -> dict[str, Any]:
        """What evaluate says of the true poses."""
        return json.loads((self.scores / "scores.json").read_text(encoding="utf-8"))

    def copy_data(self, folder: Path, source: Path | None = None) -> Path:
        """Link a dataset into ``folder`` as ``data``; a file must be replaced, never written to."""
        target = folder / "data"
        shutil.copytree(source or self.data, target, copy_function=os.link)
        return target

    def copy_run(self, folder: Path) -> Path:
        """Link the run into ``folder`` as ``run``."""
        shutil.copytree(self.run, folder / "run", copy_function=os.link)
        return folder / "run"


def make_stock(root: Path, watched: Watched, say: Callable[[str], None]) -> Stock:
    """Make the stock in ``root``.

    Raises:
        SystemExit: A command fails on valid input, so that nothing can be judged.
    """
    stock = Stock(root)
    root.mkdir(parents=True, exist_ok=True)
    for base in sorted(BASES.glob("*.yaml")):
        say(f"making {base.stem}")
        _do(watched, root, "generate", base, "--out", root / base.stem, "--workers", "1")
    say("training, predicting and scoring")
    write_gt(stock.data, stock.gt)
    train = ["--max-steps", "4", "--batch", "2", "--size", "nano", "--threads", "1", "--cache", "none"]
    _do(watched, root, "train", "densefusion-pointcloud", "--data", stock.data, "--out", stock.run, *train)
    _do(watched, root, "predict", MODEL, "--data", stock.data, "--out", stock.predictions)
    _do(watched, root, "predict", stock.run, "--data", stock.data, "--out", root / "run_predictions.csv")
    _do(watched, root, "evaluate", stock.gt, "--data", stock.data, "--out", stock.scores)
    write_crate(root)
    return stock


def _do(watched: Watched, root: Path, *words: str | Path) -> Outcome:
    outcome = watched.run(tuple(map(str, words)), root, _SECONDS)
    if outcome.code != 0:
        raise SystemExit(f"{' '.join(map(str, words))} fails on valid input: {outcome.death}\n{outcome.err[-3000:]}")
    return outcome


def write_gt(data: Path, path: Path) -> None:
    """Write the labels of the test split as a BOP pose CSV, from the files alone."""
    lines = ["scene_id,im_id,obj_id,score,R,t,time"]
    for table in sorted((data / "bop" / "test").glob("*/scene_gt.json")):
        for image, labels in json.loads(table.read_text(encoding="utf-8")).items():
            for label in labels:
                R, t = (" ".join(map(repr, label[key])) for key in ("cam_R_m2c", "cam_t_m2c"))
                lines.append(f"{int(table.parent.name)},{image},{label['obj_id']},1.0,{R},{t},0.05")
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


def write_crate(root: Path) -> None:
    """Write an object with every key, its mesh in three formats, and a recipe that puts it on the floor."""
    box = trimesh.creation.box(extents=(0.4, 0.3, 0.2))
    for ending in ("obj", "ply", "glb"):
        box.export(root / f"crate.{ending}")
    (root / "crate.yaml").write_text(yaml.safe_dump(_CRATE, sort_keys=False), encoding="utf-8")
    settings = {
        "extends": "rack.yaml",
        "description": "The rack with a crate before it.",
        "scene": {"targets": ["pallet", "crate"], "traffic": {"objects": ["crate.yaml"], "own": 2}},
    }
    (root / "with_crate.yaml").write_text(yaml.safe_dump(settings, sort_keys=False), encoding="utf-8")
    shutil.copy(BASES / "rack.yaml", root / "rack.yaml")


def crate_mesh() -> tuple[np.ndarray, np.ndarray]:
    """Return vertices (m) and faces of the crate."""
    box = trimesh.creation.box(extents=(0.4, 0.3, 0.2))
    return np.asarray(box.vertices), np.asarray(box.faces)
