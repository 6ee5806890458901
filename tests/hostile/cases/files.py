"""Datasets, runs, poses, detections and scores: every mutation of their files, given to what reads them."""

import csv
import hashlib
import json
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache, partial
from itertools import groupby, islice
from pathlib import Path
from typing import Any

import numpy as np

import warehouse_sim as ws
from tests.hostile.case import Case, Expectation, Outcome, Step, one_of
from tests.hostile.mutants import NO_JSON, Mutant, Place, leaves, mutants, put_at
from tests.hostile.stock import ESTIMATOR, FEW, Stock

# Entries of a rotation that are smaller may be zero or of the other sign: products of rows change by less than 1e-6.
_NOTHING = 4e-7
_TABLES = (".json", ".yaml", ".txt", ".csv")


@dataclass(frozen=True)
class _Files:
    """Files of one kind, and what their readers must notice."""

    pattern: str
    """Below the source."""
    readers: tuple[str, ...]
    must: str | None = None
    """Regular expression of the places in a JSON file whose values labels or scores are made of: any change of them
    must be noticed. By default that is what nobody can mean."""
    free: str = r"(?!)"
    """Of "file:place mutation", of what may be taken all the same: notes for people, and what has a meaning."""
    body: Expectation = "reject"
    """What must happen where bits are flipped: text and compressed images show it, numbers may be others."""


_ALL = (*("validate",) * 6, *("open",) * 6, *("evaluate",) * 3, "predict", "report", "convert")
_SOURCES: dict[str, tuple[_Files, ...]] = {
    "rack": (
        _Files("manifest.json", _ALL, r"^(seed|scenes|observations_per_scene|splits|formats|targets|format_version)"),
        _Files("objects.json", _ALL, r"^(?!.*pockets$)"),
        _Files("bop/camera.json", _ALL, r"."),
        _Files("bop/models*/models_info.json", _ALL, r"."),
        *(_Files(f"bop/test/*/scene_{name}.json", _ALL, r".") for name in ("gt", "gt_info", "camera")),
        _Files("bop/test/*/scene_gt_coco.json", ("validate",), r"^(images|annotations)(?!.*(width|height)$)"),
        _Files("bop/test_targets_bop*.json", _ALL, r"."),
        _Files(
            "scenes/000002.json",
            _ALL,
            r"^(scene_index|seed|split|renderer)|T_world_(camera|object)|^(?!tally).*(instance_id|obj_id|class_name)",
        ),
        _Files(
            "coco/annotations/instances_test.json",
            ("validate", "open coco"),
            r"^annotations.*(image_id|category_id|bbox|segmentation)",
        ),
        # The heading of a plane and the place of an inertial sensor that there is not are read by nobody; one bit may
        # change no more than the last digits of a number.
        _Files("kitti/testing/*/*.txt", ("validate",), free=r"planes/.*:[123]|calib/.*:7|(calib|planes).*: a bit of"),
        _Files("kitti/ImageSets/*.txt", ("validate",)),
        _Files("yolo/*/labels/test/*.txt", ("validate",), free=": a bit of"),
        _Files("bop/**/*.png", _ALL),
        _Files("kitti/**/*.png", _ALL),
        _Files("**/*.ply", _ALL),
        _Files("kitti/**/*.bin", _ALL, body="either"),
    ),
    "lanes": (
        _Files("*/**/*.png", ("validate",)),
        _Files("*/**/*.bin", ("validate",), body="either"),
        _Files("kitti/training/*/*.txt", ("validate",), free=r"planes/.*:[123]|calib/.*:7|(calib|planes).*: a bit of"),
    ),
    "run": (
        _Files("config.yaml", (*("predict run",) * 6, *("load",) * 6, "page", "train")),
        _Files("weights.safetensors", ("predict run", "load", "train"), body="either"),
        _Files("objects.safetensors", ("refine",), body="either"),
        # A run that has no calibration or result yet is a run; the result and the curves are shown as they are.
        _Files("calibration.yaml", ("predict run", "load"), free=r" (missing|a dangling link)$"),
        _Files("result.json", ("page",), r"(?!)", free=r" (missing|a dangling link)$"),
        _Files("curves.csv", ("page",), free=r":\d"),
    ),
    # A score may be any number, and so may a time; -1 is BOP's word for no time. Lines are estimates, which may be
    # wrong by millimetres.
    "gt": (
        _Files(
            "poses.csv",
            ("score", "score in Python"),
            free=r":[2-9]\.(4|17) (negative|e300|huge_integer)|:[2-9]\.1[456] negative|line deleted",
            body="either",
        ),
    ),
    "predicted": (_Files("*.uncertainty.json", ("score predicted",), free=r":covariance|(duplicated|deleted)$"),),
    "found": (_Files("found.json", ("detect", "predict found"), free=r"bbox|(duplicated|deleted|misspelt|null)$"),),
    "scores": (_Files("scores.json", ("page of scores",), r"(?!)"),),
}


def cases(stock: Stock) -> Iterator[Case]:
    """Yield the cases of all files that there are in the stock."""
    for source, tables in _SOURCES.items():
        root = stock.root / source
        for files in tables:
            for _, alike in groupby(sorted(path for path in root.glob(files.pattern)), lambda path: path.parent):
                paths = list(alike)
                for path in paths[: 4 if paths[0].suffix in _TABLES else 1]:
                    yield from _file_cases(stock, source, str(path.relative_to(root)), files)
                if len(paths) > 1 and (other := paths[-1].read_bytes()) != paths[0].read_bytes():
                    swapped = Mutant("", "its neighbour in its place", partial(bytes, other), "reject")
                    yield _case(stock, source, str(paths[0].relative_to(root)), swapped, "reject", files.readers)
    yield from _geometry_cases(stock)


def _file_cases(stock: Stock, source: str, file: str, files: _Files) -> Iterator[Case]:
    made = mutants((stock.root / source / file).read_bytes(), file, files.body)
    for mutant in islice(made, 0, None, stock.every):
        yield _case(stock, source, file, mutant, _expected(mutant, file, files), files.readers)


def _expected(mutant: Mutant, file: str, files: _Files) -> Expectation:
    """Return what must happen: who reads a value must notice that it is another one, whatever else is right."""
    if mutant.mutation in NO_JSON and file.endswith(".json"):
        return "reject"  # more digits than Python's reader takes, too
    if re.search(files.free, f"{file}:{mutant.where} {mutant.mutation}"):
        return "either"
    if files.must is None or mutant.where in ("", "document"):
        return mutant.expect
    if mutant.mutation == "duplicated":
        return "either"  # JSON's parsers take the last of two, here the same value
    if isinstance(mutant.before, (int, float)) and mutant.mutation in ("negative", "zero"):
        if mutant.mutation == "negative" and mutant.before < 0:
            return "either"  # nothing is changed
        if "cam_R_" in mutant.where and abs(mutant.before) < _NOTHING:
            return "either"
    return "reject" if re.search(files.must, mutant.where) else "either"


def _geometry_cases(stock: Stock) -> Iterator[Case]:
    """Yield geometry that cannot be and that scores depend on: who scores must see it without ``validate``."""
    gt = "bop/test/000002/scene_gt.json"
    documents = {file: json.loads((stock.data / file).read_text(encoding="utf-8")) for file in ("objects.json", gt)}
    pallet, label = documents["objects.json"]["1"], documents[gt]["0"][0]
    # With the pallet's own half turn they are a group, but a pallet upside down is another sight.
    half_turns = [[[s, 0, 0, 0], [0, -s, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]] for s in (1, -1)]
    changes: dict[str, tuple[str, Place, Any]] = {
        "diameter ten times": ("objects.json", ("1", "diameter"), 10 * pallet["diameter"]),
        "a false symmetry": ("objects.json", ("1", "symmetries"), [*pallet["symmetries"], *half_turns]),
        "the identity is missing": ("objects.json", ("1", "symmetries"), pallet["symmetries"][1:]),
        "a pocket's face is +q": ("objects.json", ("1", "pockets", 0, "face"), "+q"),
        "a pocket 10 m wide": ("objects.json", ("1", "pockets", 0, "size"), [1.2, 10.0, 0.1]),
        "behind the camera": (gt, ("0", 0, "cam_t_m2c"), [*label["cam_t_m2c"][:2], -3000.0]),
        "in the camera": (gt, ("0", 0, "cam_t_m2c"), [0.0, 0.0, 0.0]),
    }
    for name, (file, place, value) in changes.items():
        content = json.dumps(put_at(documents[file], place, value)).encode()
        mutant = Mutant(".".join(map(str, place)), name, partial(bytes, content), "reject")
        for reader in ("validate", "evaluate alone"):
            yield _case(stock, "rack", file, mutant, "reject", (reader,))


def _case(stock: Stock, source: str, file: str, mutant: Mutant, expect: Expectation, readers: Sequence[str]) -> Case:
    """Return a case: what one command takes gives what valid files give, or ``validate`` says that they are wrong."""
    what = f"{source}/{file}{':' if mutant.where else ''}{mutant.where}"
    reader = one_of(readers, what, mutant.mutation)
    steps = _steps(stock)[reader]
    if reader == "page" and mutant.path:
        expect = "either"  # it shows some settings and uses none
    if source == "lanes":
        steps = steps[:1]
    path, calls = Path(file), callable(steps[0])
    kind = "dataset" if source in ("rack", "lanes") else "run" if source == "run" else "result"
    place = "data" if kind == "dataset" else source
    names = (path.name, path.stem, path.parent.name, path.parent.parent.name, place, mutant.where.rpartition(".")[2])
    check = partial(_is_right, stock, kind, reader.partition(" ")[2]) if source != "lanes" else None
    write = partial(_write, stock, source, place, file, mutant)
    return Case(f"call {kind}" if calls else kind, what, mutant.mutation, steps, write, expect, check, names)


def _write(stock: Stock, source: str, place: str, file: str, mutant: Mutant, folder: Path) -> None:
    mutant.apply(stock.copy(source, folder, place) / file)


@cache
def _steps(stock: Stock) -> dict[str, tuple[Step, ...]]:
    """Return by reader the steps that read a file, and where they read a dataset those that look at it again."""
    opening, validate = partial(open_data, "data", ""), ("validate", "data")
    valid = ("--data", str(stock.data))
    found = ("predict", ESTIMATOR, *valid, "--out", "poses.csv", "--detections", "found/found.json")
    run = ("predict", "run", *valid, "--out", "run.csv")
    return {
        "validate": (validate, opening),
        "open": (opening, validate),
        "open coco": (partial(open_data, "data", "coco"), validate),
        "evaluate": (("evaluate", str(stock.poses), "--data", "data", "--out", "scores"), validate),
        "evaluate alone": (("evaluate", str(stock.poses), "--data", "data", "--out", "scores"),),
        "predict": (("predict", ESTIMATOR, "--data", "data", "--out", "poses.csv"), validate),
        "report": (("report", "data", "--out", "page.html"), validate),
        "convert": (("convert", "data", "--to", "linemod", "--out", "made"), validate),
        "predict run": (run,),
        "refine": ((*run, "--refine", "icp"),),  # alone reads surfaces
        "load": (partial(estimate, str(stock.data)),),
        "page": (("report", "run", "--out", "page.html"),),
        "train": (("train", "densefusion-pointcloud", *valid, "--out", "new", "--init", "run", *FEW),),
        "score": (("evaluate", "gt/poses.csv", *valid, "--out", "scores"),),
        "score in Python": (partial(score, str(stock.data)),),
        "score predicted": (("evaluate", "predicted/poses.csv", *valid, "--out", "scores"),),
        "detect": (("detect", "found/found.json", *valid, "--out", "again.json"),),
        "predict found": (found,),
        "page of scores": (("report", str(stock.data), "scores", "--out", "page.html"),),
    }


def open_data(root: str, part: str) -> dict[str, str]:
    """Open a dataset, or the folder of one format, and return a hash of labels, cameras and pixels by observation."""
    found: dict[str, str] = {}
    for obs in ws.Dataset(f"{root}/{part}"):
        arrays: list[Any] = [obs.rgb, obs.instance_mask, obs.camera.K, 0 if part else obs.depth]
        for item in obs.objects:
            arrays += [item.obj_id, item.visible_fraction, item.box_2d, item.mask, item.amodal_mask]
            arrays += [item.T_camera_object, item.size] if item.has_pose else []
        # Adding zero turns -0.0 into 0.0.
        values = [np.round(np.asarray(array, float), 5) + 0.0 for array in arrays]
        found[f"{obs.split} {obs.scene_id} {obs.image_id}"] = hashlib.sha256(b"".join(map(bytes, values))).hexdigest()
    return found


def score(data: str) -> None:
    """Score a file of poses in Python."""
    ws.evaluate("gt/poses.csv", data, out="scores")


def estimate(data: str) -> int:
    """Load a run in Python and estimate the poses of a split."""
    return len(ws.predict(ws.load_estimator("run"), data, "run.csv"))


_open_valid = cache(open_data)


def _is_right(stock: Stock, kind: str, part: str, folder: Path, outcomes: Sequence[Outcome]) -> str | None:
    """Say where what was written or read is not what the valid files give, or cannot be."""
    opened = _open_valid(str(stock.data), part if part == "coco" else "")
    for outcome in outcomes:
        if outcome.code != 0:
            return f"then {outcome.name} rejects: {outcome.err.strip().splitlines()[-1:]}"
        if outcome.name == "open_data" and outcome.value != opened:
            return "Dataset reads other labels or pixels than those of the valid data"
    scores, poses, run, page = (folder / name for name in ("scores/scores.json", "poses.csv", "run.csv", "page.html"))
    if scores.is_file() and not page.is_file():
        found = json.loads(scores.read_text(encoding="utf-8"))
        return _scores_problem(found, stock.scores, exact=kind == "dataset")
    if poses.is_file() and kind == "dataset" and _rows(poses) != _rows(stock.root / "predicted" / "poses.csv"):
        return "the predictions are not those of the valid dataset"
    if run.is_file() and (problem := _poses_problem(_rows(run), _rows(stock.root / "run.csv"))):
        return problem
    if page.is_file():
        text = re.sub(r"<(style|script|svg).*?</\1>|<[^>]*>", " ", page.read_text(encoding="utf-8"), flags=re.DOTALL)
        if wrong := re.search(r"\b(nan|inf)\b", text):
            return f"the page says {wrong.group()}"
    return None


def _scores_problem(found: Any, valid: Any, exact: bool) -> str | None:
    """Find scores that are not those of the valid dataset, leave 0-1, or are above those of the ground truth."""
    for key in ("counts", "overall", "groups", "docking_failures") if exact else ():
        ours, theirs = dict(leaves(found[key])), dict(leaves(valid[key]))
        if ours.keys() != theirs.keys() or not all(_same(ours[path], theirs[path]) for path in ours):
            return f"{key} of the scores are not those of the valid dataset"
    best = valid["overall"]["metrics"]
    for name, value in found["overall"]["metrics"].items():
        if value is not None and not name.startswith("median_") and not 0.0 <= value <= best[name] + 1e-9:
            return f"{name} is {value}"
    return None


def _same(one: Any, other: Any) -> bool:
    numbers = isinstance(one, (int, float)) and isinstance(other, (int, float))
    return bool(np.isclose(one, other, rtol=1e-6, atol=1e-6)) if numbers else bool(one == other)


def _rows(path: Path) -> list[list[str]]:
    """Return a pose CSV without the times, which no two runs share."""
    with path.open(encoding="utf-8", newline="") as file:
        return [row[:-1] for row in csv.reader(file)]


def _poses_problem(found: list[list[str]], valid: list[list[str]]) -> str | None:
    """Find fewer poses than there are visible targets, and poses beyond a hall."""
    if len(found) != len(valid):
        return f"it predicts {len(found) - 1} poses instead of {len(valid) - 1}"
    far = [row[5] for row in found[1:] if not all(abs(float(word)) < 1e5 for word in row[5].split())]
    return f"it places an object at {far[0]} mm" if far else None
