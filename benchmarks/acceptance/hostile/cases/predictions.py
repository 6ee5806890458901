"""Pose CSVs: every cell, every line, the whole file; scored against the valid dataset."""

import json
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

from benchmarks.acceptance.hostile.bytes_damage import damages
from benchmarks.acceptance.hostile.case import Case, Check, Expectation
from benchmarks.acceptance.hostile.readings import same
from benchmarks.acceptance.hostile.stock import Stock
from benchmarks.acceptance.hostile.watch import Outcome

_CELLS = ("scene_id", "im_id", "obj_id", "score", "R", "t", "time")
_VALUES = {
    "nan": "nan",
    "inf": "inf",
    "negative": "-5",
    "zero": "0",
    "e300": "1e300",
    "fraction": "1.5",
    "huge_integer": "9" * 30,
    "digits_5001": "9" * 5001,
    "string": "seven",
    "empty": "",
    "underscores": "1_0",
    "other digits": "٣",
    "quoted": '"1"',
}
# A score may be any number, and so may a time; -1 is BOP's word for no time.
_MAY_BE: dict[str, frozenset[str]] = {
    "score": frozenset({"negative", "zero", "e300", "fraction", "huge_integer", "quoted"}),
    "time": frozenset({"negative", "zero", "fraction", "quoted", "huge_integer", "e300"}),
}
_SAMPLED_LINES = 2


def cases(stock: Stock) -> Iterator[Case]:
    """Yield the cases of prediction files."""
    lines = stock.gt.read_text(encoding="ascii").splitlines()
    for number in range(1, 1 + _SAMPLED_LINES):
        for column, cell in enumerate(_CELLS):
            for name, value in _VALUES.items():
                words = lines[number].split(",")
                if words[column] != value:
                    words[column] = value
                    expect: Expectation = "either" if name in _MAY_BE.get(cell, ()) else "reject"
                    yield _lines_case(stock, f"{number}.{cell}", name, _with(lines, number, ",".join(words)), expect)
        yield from _pose_cases(stock, lines, number)
    yield from _file_cases(stock, lines)
    for damage in damages(stock.gt.read_bytes(), "gt.csv"):

        def write(folder: Path, damage=damage) -> None:  # type: ignore[no-untyped-def]
            (folder / "poses.csv").write_bytes(stock.gt.read_bytes())
            damage.apply(folder / "poses.csv")

        expect = "either" if "bit" in damage.name or damage.name == "last byte gone" else damage.expect
        yield _case(stock, "document", damage.name, write, expect, _scores_are_possible(stock))


def _pose_cases(stock: Stock, lines: list[str], number: int) -> Iterator[Case]:
    """Yield rotations that are none, and numbers too many or too few."""
    words = lines[number].split(",")
    R, t = np.array(words[4].split(), float), np.array(words[5].split(), float)
    for name, changed in {
        "mirrored": -R,
        "twice as long": 2.0 * R,
        "all zero": 0.0 * R,
        "eight numbers": R[:8],
        "ten numbers": np.append(R, 0.0),
    }.items():
        row = [*words[:4], " ".join(map(repr, changed.tolist())), *words[5:]]
        yield _lines_case(stock, f"{number}.R", name, _with(lines, number, ",".join(row)), "reject")
    for name, changed, expect in (
        ("behind the camera", t * [1, 1, -1], "either"),
        ("1e9 away", t * 1e9, "either"),
        ("two numbers", t[:2], "reject"),
    ):
        row = [*words[:5], " ".join(map(repr, np.asarray(changed).tolist())), *words[6:]]
        yield _lines_case(stock, f"{number}.t", name, _with(lines, number, ",".join(row)), expect)


def _file_cases(stock: Stock, lines: list[str]) -> Iterator[Case]:
    text = "\n".join(lines) + "\n"
    metres = [lines[0], *map(_in_metres, lines[1:])]
    whole: dict[str, tuple[bytes, Expectation, Check]] = {
        "as it is": (text.encode(), "accept", _scores_are_true(stock)),
        "UTF-8 mark": (b"\xef\xbb\xbf" + text.encode(), "accept", _scores_are_true(stock)),
        "blank lines at the end": (text.encode() + b"\n\n", "accept", _scores_are_true(stock)),
        "Windows line ends": (text.replace("\n", "\r\n").encode(), "accept", _scores_are_true(stock)),
        "no line end": (text[:-1].encode(), "accept", _scores_are_true(stock)),
        "other order": ("\n".join([lines[0], *lines[:0:-1]]).encode(), "accept", _scores_are_true(stock)),
        "header alone": (f"{lines[0]}\n".encode(), "either", _scores_are_possible(stock)),
        "no header": ("\n".join(lines[1:]).encode(), "reject", _scores_are_possible(stock)),
        "header twice": ("\n".join([lines[0], *lines]).encode(), "reject", _scores_are_possible(stock)),
        "columns swapped": (
            text.replace("scene_id,im_id", "im_id,scene_id", 1).encode(),
            "reject",
            _scores_are_possible(stock),
        ),
        "semicolons": (text.replace(",", ";").encode(), "reject", _scores_are_possible(stock)),
        "every row twice": ("\n".join([*lines, *lines[1:]]).encode(), "either", _says("duplicate", "twice", "same")),
        "metres": ("\n".join(metres).encode(), "either", _says("millimet")),
        "half of the rows": ("\n".join(lines[: 1 + len(lines) // 2]).encode(), "either", _scores_are_possible(stock)),
        "UTF-16": (text.encode("utf-16"), "reject", _scores_are_possible(stock)),
    }
    for name, (content, expect, check) in whole.items():

        def write(folder: Path, content: bytes = content) -> None:
            (folder / "poses.csv").write_bytes(content)

        yield _case(stock, "document", name, write, expect, check)


def _in_metres(line: str) -> str:
    words = line.split(",")
    words[5] = " ".join(repr(float(word) / 1000.0) for word in words[5].split())
    return ",".join(words)


def _with(lines: list[str], number: int, line: str) -> list[str]:
    return [*lines[:number], line, *lines[number + 1 :]]


def _lines_case(stock: Stock, where: str, mutation: str, lines: list[str], expect: Expectation) -> Case:
    def write(folder: Path) -> None:
        (folder / "poses.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")

    return _case(stock, where, mutation, write, expect, _scores_are_possible(stock))


def _case(
    stock: Stock, where: str, mutation: str, write: Callable[[Path], None], expect: Expectation, check: Check
) -> Case:
    step = ("evaluate", "poses.csv", "--data", str(stock.data), "--out", "scores")
    return Case("predictions", where, mutation, (step,), write, expect, check, ("poses.csv",))


def _read(folder: Path) -> dict:  # type: ignore[type-arg]
    return json.loads((folder / "scores" / "scores.json").read_text(encoding="utf-8"))  # type: ignore[no-any-return]


def _scores_are_true(stock: Stock) -> Check:
    def check(folder: Path, outcomes: Sequence[Outcome]) -> str | None:
        if same(_read(folder)["overall"], stock.true_scores["overall"]):
            return None
        return "the scores are not those of the same poses"

    return check


def _scores_are_possible(stock: Stock) -> Check:
    """Return a check that no fraction leaves 0-1, and that nothing is better than the ground truth."""

    def check(folder: Path, outcomes: Sequence[Outcome]) -> str | None:
        gt = stock.true_scores["overall"]["metrics"]
        for name, value in _read(folder)["overall"]["metrics"].items():
            if name.startswith("median_") or value is None:
                continue
            if not (np.isfinite(value) and 0.0 <= value <= gt[name] + 1e-9):
                return f"{name} is {value}"
        return None

    return check


def _says(*words: str) -> Check:
    def check(folder: Path, outcomes: Sequence[Outcome]) -> str | None:
        said = outcomes[0].out + outcomes[0].err
        return None if any(word in said.lower() for word in words) else f"says nothing of {words[0]}"

    return check
