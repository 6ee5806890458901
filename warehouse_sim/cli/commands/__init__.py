"""The commands of ``warehouse-sim``: four groups, each with a line and two examples."""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Any

GROUPS = {
    "make": "Make data",
    "look": "Look at data",
    "learn": "Train and predict",
    "score": "Score",
}
"""Groups by their short name, in the order of the help page."""


_TOGETHER = {"convert": "export", "export-scene": "export", "report": "evaluate", "validate": "view"}
"""Commands that share the module of another."""


@dataclass(frozen=True)
class Command:
    """One command; its function is imported when it is called."""

    name: str
    """As it is typed."""
    group: str
    """Key of ``GROUPS``."""
    summary: str
    """One line of the help page."""
    examples: tuple[str, str]
    """Two command lines without the program's name."""
    outputs: str = "DIR"
    """What ``--out`` names."""

    def function(self) -> Callable[..., Any]:
        """Import and return what runs the command: the function of its name."""
        module = import_module(f"warehouse_sim.cli.commands.{_TOGETHER.get(self.name, self.name)}")
        found: Callable[..., Any] = getattr(
            module, "list_names" if self.name == "list" else self.name.replace("-", "_")
        )
        return found


_ALL = (
    Command(
        "generate",
        "make",
        "Make a dataset from a recipe, or merge shards of one.",
        ("generate demo --out out/demo --scenes 4", "generate --merge out/a out/b --out out/all"),
    ),
    Command(
        "preview",
        "make",
        "Render a contact sheet of one scene, or check that the scene stands.",
        ("preview selective_rack --seed 3", "preview dock_staging --scene 2 --check"),
        "FILE",
    ),
    Command(
        "convert",
        "make",
        "Write a dataset in further formats.",
        ("convert out/demo --to coco yolo --out out/coco", "convert LINEMOD --to bop --out out/linemod"),
    ),
    Command(
        "export-scene",
        "make",
        "Write one scene as USD, MJCF or GLB.",
        ("export-scene demo --to usd --out scene.usdc", "export-scene demo --to mjcf --out scene.xml --scene 3"),
        "FILE",
    ),
    Command(
        "list",
        "look",
        "List recipes, objects, sensors, presets, estimators, formats and suites.",
        ("list", "list cameras --json"),
        "FILE",
    ),
    Command(
        "view",
        "look",
        "Show a dataset in the Rerun viewer, or summarise it in numbers and pictures.",
        ("view out/demo --split test", "view out/demo --summary"),
    ),
    Command(
        "validate",
        "look",
        "Check a dataset, or regenerate some of its scenes and compare.",
        ("validate out/demo", "validate out/demo --regenerate 24"),
    ),
    Command(
        "train",
        "learn",
        "Train an estimator, a detector or a segmenter.",
        (
            "train densefusion-depth --data out/demo --out out/run",
            "train detector-depth --data out/demo --out out/detector --init detector-depth",
        ),
    ),
    Command(
        "detect",
        "learn",
        "Find objects in the images of a dataset and score the detections.",
        (
            "detect detector-depth --data out/demo --out out/found.json",
            "detect detector-depth+segmenter-depth --data out/demo --out out/masks.json",
        ),
        "FILE",
    ),
    Command(
        "predict",
        "learn",
        "Estimate the poses of a dataset's objects.",
        (
            "predict densefusion-depth --data out/demo --out out/poses.csv",
            "predict my_estimator.py:Mine --data out/demo --out out/mine.csv",
        ),
        "FILE",
    ),
    Command(
        "export",
        "learn",
        "Write a trained network as ONNX.",
        ("export densefusion-depth --out pose.onnx", "export detector-depth --out detector.onnx"),
        "FILE",
    ),
    Command(
        "evaluate",
        "score",
        "Score predicted poses against the ground truth.",
        (
            "evaluate out/poses.csv --data out/demo --out out/scores",
            "evaluate out/poses.csv --data out/demo --out out/scores --bop --vsd",
        ),
    ),
    Command(
        "report",
        "score",
        "Write one HTML page about datasets, runs, scores or suites.",
        ("report out/demo out/scores --out report.html", "report out/bench/results --out bench.html"),
        "FILE",
    ),
    Command(
        "bench",
        "score",
        "Run a suite of the benchmark.",
        ("bench industrial --quick", "bench occlusion --estimators my_poses.csv --quick"),
    ),
    Command(
        "demo",
        "score",
        "Run the whole chain on one recipe: generate, train, predict, evaluate, report.",
        ("demo", "demo --recipe smoke --scenes 6 --max-minutes 1 --out out/small"),
    ),
)

COMMANDS = {command.name: command for command in _ALL}
"""Command by name, in the order of the help page."""
