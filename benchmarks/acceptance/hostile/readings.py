"""What reads a dataset, a run or predictions, and when what comes of it is right: by comparison with the valid one."""

import csv
import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.acceptance.hostile.case import Check, nothing_to_check
from benchmarks.acceptance.hostile.documents import leaves
from benchmarks.acceptance.hostile.stock import MODEL, Stock
from benchmarks.acceptance.hostile.watch import Outcome

Steps = tuple[tuple[str, ...], ...]
_COMPARED = ("counts", "overall", "groups", "docking_failures")
_SAME = 1e-6


def dataset_reading(stock: Stock, command: str, rig: bool = False) -> tuple[Steps, Check]:
    """Return the command lines that read the dataset ``data``, and what must be true when they succeed.

    What ``validate`` takes is scored and predicted on, and must give what the valid dataset gives. What another command
    takes must give that too, unless ``validate`` says that the data are wrong.
    """
    evaluate = ("evaluate", str(stock.gt), "--data", "data", "--out", "scores")
    predict = ("predict", MODEL, "--data", "data", "--out", "poses.csv")
    validate = ("validate", "data")
    if rig:
        return (validate,), nothing_to_check
    steps: dict[str, Steps] = {
        "validate": (validate, evaluate, predict),
        "evaluate": (evaluate, validate),
        "predict": (predict, validate),
        "report": (("report", "data", str(stock.run), "--out", "page.html"), validate),
        "train": (_train("data"), validate),
    }

    def check(folder: Path, outcomes: Sequence[Outcome]) -> str | None:
        last = outcomes[-1]
        if command != "validate" and last.argv[0] == "validate" and last.code == 1:
            return None
        if last.code != 0:
            return f"then {last.argv[0]} rejects: {last.err.strip().splitlines()[-1:]}"
        return next(filter(None, (_other_scores(stock, folder), _other_poses(stock, folder), _no_page(folder))), None)

    return steps[command], check


def _train(data: str) -> tuple[str, ...]:
    limits = ("--max-steps", "2", "--batch", "2", "--size", "nano", "--threads", "1", "--cache", "none")
    return ("train", "densefusion-pointcloud", "--data", data, "--out", "trained", *limits)


def _other_scores(stock: Stock, folder: Path) -> str | None:
    path = folder / "scores" / "scores.json"
    if not path.is_file():
        return None
    scores = json.loads(path.read_text(encoding="utf-8"))
    for key in _COMPARED:
        if not same(scores[key], stock.true_scores[key]):
            return f"{key} of the scores differ from those of the valid dataset"
    return None


def _other_poses(stock: Stock, folder: Path) -> str | None:
    path = folder / "poses.csv"
    if not path.is_file():
        return None
    return None if rows(path) == rows(stock.predictions) else "its predictions differ from those of the valid dataset"


def _no_page(folder: Path) -> str | None:
    path = folder / "page.html"
    return page_problem(path) if path.is_file() else None


def rows(path: Path) -> list[list[str]]:
    """Return a pose CSV without the times, which no two runs share."""
    with path.open(encoding="utf-8-sig", newline="") as file:
        return [row[:-1] for row in csv.reader(file)]


def same(found: Any, wanted: Any) -> bool:
    """Return whether two plain documents hold the same, numbers to six digits."""
    ours, theirs = dict(leaves(found)), dict(leaves(wanted))
    return ours.keys() == theirs.keys() and all(_same_leaf(ours[path], theirs[path]) for path in ours)


def _same_leaf(one: Any, other: Any) -> bool:
    if isinstance(one, (int, float)) and isinstance(other, (int, float)):
        return bool(np.isclose(one, other, rtol=_SAME, atol=_SAME))
    return bool(one == other)


def page_problem(path: Path) -> str | None:
    """Return what is wrong with a report, if anything: no page, or a number that is none."""
    if not path.is_file():
        return "no page was written"
    text = re.sub(r"<(style|script|svg).*?</\1>|<[^>]*>", " ", path.read_text(encoding="utf-8"), flags=re.DOTALL)
    found = re.search(r"\b(nan|inf)\b", text)
    return f"the page says {found.group()}" if found else None
