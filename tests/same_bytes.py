"""Hold datasets of two versions of the code against each other, file by file.

    python -m tests.same_bytes make FOLDER            # some two minutes on two cores
    python -m tests.same_bytes compare BEFORE AFTER

The first generates the sets with the code of this checkout; the second says which files differ, by how much in images,
and whether a manifest lost a key or has another value there. Bytes are those of one machine: make both folders on it.
"""

import json
import sys
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import tyro

from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.sensors.rig import rig_names

SETS = {
    "smoke": ("smoke", 4),
    "industrial": ("industrial", 2),
    "lighting": ("lighting_study", 1),
    "occlusion": ("occlusion_study", 1),
}
"""Name of a set -> its recipe and number of scenes; one scene of ``smoke`` for each rig comes on top."""


def make(folder: tyro.conf.Positional[Path], only: tuple[str, ...] = (), workers: int = 2) -> None:
    """Generate the sets whose folders do not exist yet.

    Args:
        folder: Where they go, one folder a set.
        only: Names of sets; all by default.
        workers: Processes.
    """
    recipes = folder / "recipes"
    recipes.mkdir(parents=True, exist_ok=True)
    wanted = dict(SETS)
    for rig in rig_names():
        file = recipes / f"rig_{rig}.yaml"
        text = f"extends: smoke\ndescription: smoke seen by {rig}\nsensors: {{rig: {rig}}}\n"
        file.write_text(text, encoding="utf-8")
        wanted[file.stem] = str(file), 1
    for name, (recipe, scenes) in wanted.items():
        if (not only or name in only) and not (folder / name).exists():
            print(f"making {name}", file=sys.stderr)
            generate(load_recipe(recipe), folder / name, GenerateConfig(scenes=scenes, workers=workers))


def compare(before: tyro.conf.Positional[Path], after: tyro.conf.Positional[Path]) -> int:
    """Print a line for each file that differs, is missing or is new; exit code 1 if there is one.

    Args:
        before: Folder that ``make`` wrote with one version of the code.
        after: The same of another version.
    """
    lines = differences(before, after)
    print("\n".join(lines) or "no file differs")
    return int(bool(lines))


def differences(before: Path, after: Path) -> list[str]:
    """Return a line for each file that differs, is missing or is new; a manifest may gain keys."""
    files = [{path.relative_to(root) for path in root.rglob("*") if path.is_file()} for root in (before, after)]
    lines = [f"{path}: missing" for path in sorted(files[0] - files[1])]
    lines += [f"{path}: new" for path in sorted(files[1] - files[0])]
    for path in sorted(files[0] & files[1]):
        if (before / path).read_bytes() != (after / path).read_bytes():
            lines += [f"{path}: {text}" for text in _differences(before / path, after / path)]
    return lines


def _differences(before: Path, after: Path) -> list[str]:
    if before.name == "manifest.json":
        old, new = (json.loads(path.read_text(encoding="utf-8")) for path in (before, after))
        return _lost(old, new, "manifest")
    if before.suffix != ".png":
        return ["differs"]
    old, new = (cv2.imread(str(path), cv2.IMREAD_UNCHANGED) for path in (before, after))
    if old.shape != new.shape:
        return [f"is {new.shape}, was {old.shape}"]
    off = np.abs(old.astype(int) - new.astype(int))
    return [f"differs by {off.max()} at most, {off.mean():.4f} on average, in {(off > 0).mean():.2%} of the values"]


def _lost(before: Any, after: Any, where: str) -> list[str]:
    """Return the keys of ``before`` that are missing or have another value."""
    if not (isinstance(before, dict) and isinstance(after, dict)):
        return [] if before == after else [f"{where} was {before}, is {after}"]
    lines = [f"{where}.{key} is missing" for key in sorted(before.keys() - after.keys())]
    for key in sorted(before.keys() & after.keys()):
        lines += _lost(before[key], after[key], f"{where}.{key}")
    return lines


if __name__ == "__main__":
    sys.exit(tyro.extras.subcommand_cli_from_dict({"make": make, "compare": compare}, description=__doc__) or 0)
