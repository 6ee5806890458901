"""Command lines: outputs that cannot be written, inputs that are not there, numbers and names that are none."""

import os
from collections.abc import Callable, Iterator
from pathlib import Path

from benchmarks.acceptance.hostile.case import Case, Check, Expectation, nothing_to_check
from benchmarks.acceptance.hostile.cases.recipes import reading
from benchmarks.acceptance.hostile.stock import BASES, MODEL, Stock

Words = tuple[str, ...]
_RECIPE = str(BASES / "rack.yaml")
_FEW = ("--max-steps", "2", "--batch", "2", "--size", "nano", "--threads", "1", "--cache", "none")


def cases(stock: Stock) -> Iterator[Case]:
    """Yield the cases of command lines."""
    yield from _outputs(stock)
    yield from _inputs(stock)
    yield from _numbers(stock)
    yield from _names(stock)


def _lines(stock: Stock) -> dict[str, Words]:
    """Return a valid command line of every command that writes, up to its output."""
    data = str(stock.data)
    return {
        "preview": ("preview", _RECIPE, "--out"),
        "list": ("list", "objects", "epal1", "--out"),
        "generate": ("generate", _RECIPE, "--scenes", "1", "--workers", "1", "--out"),
        "train": ("train", "densefusion-pointcloud", "--data", data, *_FEW, "--out"),
        "predict": ("predict", MODEL, "--data", data, "--out"),
        "evaluate": ("evaluate", str(stock.gt), "--data", data, "--out"),
        "export": ("export", str(stock.run), "--out"),
        "report": ("report", data, "--out"),
    }


def _outputs(stock: Stock) -> Iterator[Case]:
    places: dict[str, tuple[str, Callable[[Path], None], Expectation]] = {
        "/proc/x": ("/proc/x", _nothing, "reject"),
        "/proc/x/y/z": ("/proc/x/y/z", _nothing, "reject"),
        "/dev/null/x": ("/dev/null/x", _nothing, "reject"),
        "inside a file": ("file/x", _file, "reject"),
        "a dangling link": ("link", _dangling, "either"),
        "a link to itself": ("loop", _loop, "either"),
        "a name of 300 letters": ("x" * 300, _nothing, "reject"),
        "a null byte": ("a\x00b", _nothing, "reject"),
        "a folder that may not be written": ("closed/x", _closed, "reject" if os.geteuid() else "either"),
        "empty": ("", _nothing, "either"),
        "a new folder in a new folder": ("new/newer/out", _nothing, "either"),
        "spaces and umlauts": ("größe und mehr", _nothing, "either"),
    }
    for command, words in _lines(stock).items():
        for name, (out, write, expect) in places.items():
            yield _case(command, f"--out {name}", (*words, out), expect, write)
        whole = command in ("generate", "train", "evaluate")
        yield _case(command, "--out a file", (*words, "file"), "reject" if whole else "either", _file)
        yield _case(command, "--out a folder", (*words, "folder"), "either" if whole else "reject", _folder)
        yield _case(
            command, "--out a full folder", (*words, "full"), "reject" if command != "evaluate" else "either", _full
        )


def _inputs(stock: Stock) -> Iterator[Case]:
    data, gt, run = str(stock.data), str(stock.gt), str(stock.run)
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
    }
    commands: dict[str, Callable[[str], Words]] = {
        "preview": lambda path: ("preview", path, "--out", "x.png"),
        "preview --check": lambda path: ("preview", path, "--check"),
        "generate": lambda path: ("generate", path, "--out", "x", "--workers", "1"),
        "list": lambda path: ("list", "objects", path, "--out", "x.png"),
        "validate": lambda path: ("validate", path),
        "train --data": lambda path: ("train", "densefusion-pointcloud", "--data", path, "--out", "x", *_FEW),
        "train --init": lambda path: (
            "train",
            "densefusion-pointcloud",
            "--data",
            data,
            "--init",
            path,
            "--out",
            "x",
            *_FEW,
        ),
        "train estimator": lambda path: ("train", path, "--data", data, "--out", "x", *_FEW),
        "predict run": lambda path: ("predict", path, "--data", data, "--out", "x.csv"),
        "predict --data": lambda path: ("predict", MODEL, "--data", path, "--out", "x.csv"),
        "evaluate": lambda path: ("evaluate", path, "--data", data, "--out", "x"),
        "evaluate --data": lambda path: ("evaluate", gt, "--data", path, "--out", "x"),
        "export": lambda path: ("export", path, "--out", "x.onnx"),
        "export-scene": lambda path: ("export-scene", path, "--to", "glb", "--out", "x.glb"),
        "report": lambda path: ("report", path, run, "--out", "x.html"),
    }
    for command, line in commands.items():
        for name, path in paths.items():
            yield _case(command, f"input {name}", line(path), "reject", _everything)


def _numbers(stock: Stock) -> Iterator[Case]:
    data = str(stock.data)
    for option in ("--scenes", "--seed", "--workers", "--difficulty"):
        line = ("generate", _RECIPE, "--out", "made", *(() if option == "--scenes" else ("--scenes", "1")))
        line += () if option == "--workers" else ("--workers", "1")
        for value in ("-1", "0", "nan", "inf", "1e300", "9" * 30, "1.5", "seven", "", "9" * 5001):
            fine = (option, value) in {("--seed", "0"), ("--difficulty", "0"), ("--seed", "9" * 30), ("--workers", "0")}
            check = reading("generate", _RECIPE)[1]
            yield _case(
                "generate",
                f"{option} {value[:30]}",
                (*line, option, value),
                "either" if fine else "reject",
                check=check,
            )
    for command, option in (
        ("preview", "--scene"),
        ("preview", "--seed"),
        ("preview", "--difficulty"),
        ("preview --check", "--scene"),
    ):
        out = ("--out", "sheet.png") if command == "preview" else ("--check",)
        for value in ("-1", "nan", "1e300", "9" * 30, "1.5", "seven"):
            large = value == "9" * 30 and option != "--difficulty"
            yield _case(
                command, f"{option} {value}", ("preview", _RECIPE, *out, option, value), "either" if large else "reject"
            )
    settings = (
        *("--batch", "--max-steps", "--max-minutes", "--learning-rate", "--ema", "--devices", "--validations"),
        *(
            "--weight-decay",
            "--clip-norm",
            "--refiner-iterations",
            "--refiner-start",
            "--warmup-steps",
            "--workers",
            "--threads",
        ),
        *("--augment.yaw", "--augment.drop-fraction", "--augment.erode-px", "--loss.confidence-weight"),
    )
    for option in settings:
        for value in ("-1", "nan", "inf", "1e300", "9" * 30):
            line = ("train", "densefusion-pointcloud", "--data", data, "--out", "x", *_FEW, option, value)
            endless = option in ("--max-steps", "--max-minutes") and value == "9" * 30
            yield _case("train", f"{option} {value}", line, "reject" if not endless else "either")
    for option in ("--images-at-once", "--seed", "--threads", "--icp.iterations", "--icp.max-distance"):
        for value in ("-1", "0", "nan", "1e300", "9" * 30):
            line = ("predict", MODEL, "--data", data, "--out", "x.csv", "--refine", "icp", option, value)
            fine = (value == "0" and option == "--seed") or (
                value == "9" * 30 and option in ("--seed", "--images-at-once")
            )
            yield _case(
                "predict", f"{option} {value}", line, "either" if fine or option.startswith("--icp") else "reject"
            )


def _names(stock: Stock) -> Iterator[Case]:
    data, gt = str(stock.data), str(stock.gt)
    generate = ("generate", _RECIPE, "--out", "made", "--scenes", "1", "--workers", "1")
    lines: dict[str, tuple[Words, Expectation]] = {
        "no command": ((), "reject"),
        "unknown command": (("nonsense",), "reject"),
        "unknown option": ((*generate, "--bogus", "1"), "reject"),
        "unknown recipe": (("preview", "demoo"), "reject"),
        "unknown backend": ((*generate, "--backend", "vulkan"), "reject"),
        "unknown format": ((*generate, "--formats", "nuscenes"), "reject"),
        "a format twice": ((*generate, "--formats", "bop", "bop"), "reject"),
        "no format": ((*generate, "--formats"), "reject"),
        "a format that climbs": ((*generate, "--formats", "../../x"), "reject"),
        "unknown estimator": (("train", "densefusionn", "--data", data, "--out", "x", *_FEW), "reject"),
        "unknown object": (
            ("train", "densefusion", "--data", data, "--out", "x", "--objects", "spoon", *_FEW),
            "reject",
        ),
        "unknown size": (("train", "densefusion", "--data", data, "--out", "x", "--size", "huge"), "reject"),
        "unknown split": (("evaluate", gt, "--data", data, "--out", "x", "--split", "holdout"), "reject"),
        "a split that climbs": (("predict", MODEL, "--data", data, "--out", "x.csv", "--split", "../test"), "reject"),
        "another split": (("evaluate", gt, "--data", data, "--out", "x", "--split", "val"), "reject"),
        "unknown selection": (("predict", MODEL, "--data", data, "--out", "x.csv", "--selection", "best"), "reject"),
        "unknown catalog object": (("list", "objects", "spoon", "--out", "x.png"), "reject"),
        "no folder to report": (("report", "--out", "x.html"), "reject"),
        "a dataset twice": (("train", "densefusion-pointcloud", "--data", data, data, "--out", "x", *_FEW), "either"),
        "resume of nothing": ((*generate, "--resume"), "either"),
        "resume of no run": (
            ("train", "densefusion-pointcloud", "--data", data, "--out", "x", "--resume", *_FEW),
            "either",
        ),
        "list": (("list",), "accept"),
        "list and more": (("list", "more"), "reject"),
        "help": (("generate", "--help"), "accept"),
    }
    for name, (words, expect) in lines.items():
        yield _case(words[0] if words else "-", name, words or ("--bogus",), expect)


def _case(
    command: str,
    mutation: str,
    words: Words,
    expect: Expectation,
    write: Callable[[Path], None] = lambda folder: None,
    check: Check = nothing_to_check,
) -> Case:
    return Case("command line", command, mutation, (words,), write, expect, check)


def _nothing(folder: Path) -> None:
    """Leave the folder as it is."""


def _file(folder: Path) -> None:
    (folder / "file").write_text("something else\n", encoding="ascii")


def _folder(folder: Path) -> None:
    (folder / "folder").mkdir()


def _closed(folder: Path) -> None:
    (folder / "closed").mkdir(mode=0o500)


def _full(folder: Path) -> None:
    (folder / "full").mkdir()
    (folder / "full" / "of.txt").write_text("something else\n", encoding="ascii")


def _dangling(folder: Path) -> None:
    (folder / "link").symlink_to(folder / "nowhere" / "at" / "all")


def _loop(folder: Path) -> None:
    (folder / "loop").symlink_to("loop")


def _everything(folder: Path) -> None:
    for write in (_file, _folder, _full, _dangling, _loop):
        write(folder)
