"""Command lines: outputs that cannot be written, inputs that are not there, numbers and names that are none."""

import os
from collections.abc import Iterator
from pathlib import Path

from tests.hostile.case import Case, Check, Expectation
from tests.hostile.cases.recipes import dataset_is_sane
from tests.hostile.stock import ESTIMATOR, FEW, RACK, Stock

Words = tuple[str, ...]
_HUGE = "9" * 30


def cases(stock: Stock) -> Iterator[Case]:
    """Yield the cases of command lines."""
    data, gt, recipe = str(stock.data), str(stock.poses), str(RACK)
    generate = ("generate", recipe, "--scenes", "1", "--workers", "1", "--out")
    train = ("train", "densefusion-pointcloud", "--data", data, *FEW, "--out")
    predict = ("predict", ESTIMATOR, "--data", data, "--out")
    yield from _outputs(
        {
            "preview": ("preview", recipe, "--out"),
            "list": ("list", "objects", "epal1", "--out"),
            "generate": generate,
            "train": train,
            "predict": predict,
            "evaluate": ("evaluate", gt, "--data", data, "--out"),
            "report": ("report", data, "--out"),
            "convert": ("convert", data, "--to", "yolo", "--out"),
            "detect": ("detect", "gt", "--data", data, "--out"),
            "export-scene": ("export-scene", recipe, "--to", "glb", "--out"),
        }
    )
    yield from _inputs(
        {
            "preview": ("preview", "?", "--out", "x.png"),
            "preview --check": ("preview", "?", "--check"),
            "generate": ("generate", "?", "--out", "x", "--workers", "1"),
            "generate --merge": ("generate", "--merge", "?", "--out", "x"),
            "list": ("list", "objects", "?", "--out", "x.png"),
            "validate": ("validate", "?"),
            "view": ("view", "?", "--summary"),
            "convert": ("convert", "?", "--to", "coco", "--out", "x"),
            "train --data": ("train", "densefusion-pointcloud", "--data", "?", "--out", "x", *FEW),
            "train --init": (*train, "x", "--init", "?"),
            "train estimator": ("train", "?", "--data", data, "--out", "x", *FEW),
            "predict run": ("predict", "?", "--data", data, "--out", "x.csv"),
            "predict --data": ("predict", ESTIMATOR, "--data", "?", "--out", "x.csv"),
            "predict --detections": (*predict, "x.csv", "--detections", "?"),
            "evaluate": ("evaluate", "?", "--data", data, "--out", "x"),
            "evaluate --data": ("evaluate", gt, "--data", "?", "--out", "x"),
            "detect": ("detect", "?", "--data", data, "--out", "x.json"),
            "export": ("export", "?", "--out", "x.onnx"),
            "export-scene": ("export-scene", "?", "--to", "glb", "--out", "x.glb"),
            "report": ("report", "?", data, "--out", "x.html"),
            "bench": ("bench", "?", "--quick", "--out", "x"),
        }
    )
    yield from _numbers(generate, predict, train, ("preview", recipe, "--check"))
    yield from _names(stock, generate, predict, train)


def _outputs(lines: dict[str, Words]) -> Iterator[Case]:
    places: dict[str, tuple[str, Expectation]] = {
        "/proc/x": ("/proc/x", "reject"),
        "/proc/x/y/z": ("/proc/x/y/z", "reject"),
        "/dev/null/x": ("/dev/null/x", "reject"),
        "inside a file": ("file/x", "reject"),
        "a dangling link": ("link", "either"),
        "a link to itself": ("loop", "either"),
        "a name of 300 letters": ("x" * 300, "reject"),
        "a null byte": ("a\x00b", "reject"),
        "a folder that may not be written": ("closed/x", "reject" if os.geteuid() else "either"),
        "empty": ("", "either"),
        "a new folder in a new folder": ("new/newer/out", "either"),
        "spaces and umlauts": ("größe und mehr", "either"),
    }
    for command, words in lines.items():
        folders = command in ("generate", "train", "evaluate", "convert")
        own: dict[str, tuple[str, Expectation]] = {
            "a file": ("file", "reject" if folders else "either"),
            "a folder": ("folder", "either" if folders else "reject"),
            "a full folder": ("full", "either" if command == "evaluate" else "reject"),
        }
        for name, (out, expect) in (places | own).items():
            yield _case(command, f"--out {name}", (*words, out), expect)


def _inputs(lines: dict[str, Words]) -> Iterator[Case]:
    paths = {
        "missing": "no/such/thing",
        "empty folder": "folder",
        "a file": "file",
        "a folder of other things": "full",
        "/dev/null": "/dev/null",
        "a dangling link": "link",
        "a link to itself": "loop",
        "a null byte": "a\x00b",
        "empty": "",
        "/proc/self/mem": "/proc/self/mem",
        "a name of 300 letters": "x" * 300,
    }
    for command, words in lines.items():
        for name, path in paths.items():
            yield _case(command, f"input {name}", tuple(path if word == "?" else word for word in words), "reject")


def _numbers(generate: Words, predict: Words, train: Words, check: Words) -> Iterator[Case]:
    wrong = ("-1", "0", "nan", "inf", "1e300", _HUGE, "1.5", "seven", "", "9" * 5001)
    poses = (*predict, "x.csv", "--refine", "icp")
    options: dict[str, tuple[Words, frozenset[str]]] = {
        "--scenes": (("generate", str(RACK), "--workers", "1", "--out", "made"), frozenset()),
        "--seed": ((*generate, "made"), frozenset({"0", _HUGE})),
        "--workers": (("generate", str(RACK), "--scenes", "1", "--out", "made"), frozenset()),
        "--difficulty": ((*generate, "made"), frozenset({"0"})),
        "--scene-limit": ((*generate, "made"), frozenset({"1.5", "inf", "1e300", _HUGE})),
        "--scene": (check, frozenset({"0", _HUGE})),
        "--threads": (poses, frozenset({_HUGE})),
        **dict.fromkeys(("--reject",), (poses, frozenset({"0"}))),
        **dict.fromkeys(
            ("--batch", "--learning-rate", "--ema", "--validations",
             "--max-minutes", "--refiner-iterations", "--augment.yaw", "--loss.confidence-weight"),
            ((*train, "x"), frozenset({"0", "1.5", _HUGE})),
        ),
    }  # fmt: skip
    for option, (words, fine) in options.items():
        for value in wrong:
            made = dataset_is_sane if words[0] == "generate" else None
            expect: Expectation = "either" if value in fine else "reject"
            yield _case(words[0], f"{option} {value[:30]}", (*words, option, value), expect, made)


def _names(stock: Stock, generate: Words, predict: Words, train: Words) -> Iterator[Case]:
    data, evaluate = str(stock.data), ("evaluate", str(stock.poses), "--data", str(stock.data), "--out", "x")
    wrong: dict[str, Words] = {
        "no command": (),
        "unknown command": ("nonsense",),
        "unknown option": (*generate, "made", "--bogus", "1"),
        "unknown recipe": ("preview", "demoo"),
        "unknown backend": (*generate, "made", "--backend", "vulkan"),
        "unknown format": (*generate, "made", "--formats", "nuscenes"),
        "a format twice": (*generate, "made", "--formats", "bop", "bop"),
        "no format": (*generate, "made", "--formats"),
        "a format that climbs": (*generate, "made", "--formats", "../../x"),
        "unknown estimator": ("train", "densefusionn", "--data", data, "--out", "x"),
        "unknown object": (*train, "x", "--objects", "spoon"),
        "unknown size": ("train", "densefusion", "--data", data, "--out", "x", "--size", "huge"),
        "unknown split": (*evaluate, "--split", "holdout"),
        "a split that climbs": (*predict, "x.csv", "--split", "../test"),
        "another split": (*evaluate, "--split", "val"),
        "unknown selection": (*predict, "x.csv", "--selection", "best"),
        "unknown detector": (*predict, "x.csv", "--detections", "gtt"),
        "unknown catalog object": ("list", "objects", "spoon", "--out", "x.png"),
        "no folder to report": ("report", "--out", "x.html"),
        "list and more": ("list", "more"),
        "unknown suite": ("bench", "industral"),
    }
    right: dict[str, Words] = {
        "a dataset twice": (*train[:4], data, *train[4:], "x"),
        "resume of nothing": (*generate, "made", "--resume"),
        "resume of no run": (*train, "x", "--resume"),
        "list": ("list",),
        "help": ("generate", "--help"),
        "version": ("--version",),
    }
    for name, words in wrong.items():
        yield _case(words[0] if words else "-", name, words or ("--bogus",), "reject")
    for name, words in right.items():
        yield _case(words[0], name, words, "either" if "resume" in name or "twice" in name else "accept")


def _case(command: str, mutation: str, words: Words, expect: Expectation, check: Check | None = None) -> Case:
    return Case("command line", command, mutation, (words,), _write, expect, check)


def _write(folder: Path) -> None:
    (folder / "file").write_text("something else\n", encoding="ascii")
    (folder / "folder").mkdir()
    (folder / "full").mkdir()
    (folder / "full" / "of.txt").write_text("something else\n", encoding="ascii")
    (folder / "closed").mkdir(mode=0o500)
    (folder / "link").symlink_to(folder / "nowhere" / "at" / "all")
    (folder / "loop").symlink_to("loop")
