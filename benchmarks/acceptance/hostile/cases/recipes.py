"""Recipes and rigs: every setting of four base recipes that together hold nearly all there are."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import yaml

from benchmarks.acceptance.hostile.case import Case, Check
from benchmarks.acceptance.hostile.documents import Mutant, leaves, mutated_document, mutated_leaf
from benchmarks.acceptance.hostile.draw import one_of
from benchmarks.acceptance.hostile.sane_dataset import dataset_problem
from benchmarks.acceptance.hostile.sane_image import image_problem
from benchmarks.acceptance.hostile.stock import BASES, Stock
from benchmarks.acceptance.hostile.watch import Outcome

# Of each base, the parts in which it differs from the others; the first is mutated as a whole.
_OWN_PARTS: dict[str, tuple[tuple[str, ...], ...]] = {
    "rack": ((),),
    "lanes": (("scene", "layout"), ("scene", "lights"), ("scene", "traffic"), ("scene", "lanes"), ("sensors",)),
    "drive": (("scene", "layout"), ("scene", "viewpoints"), ("paired_variants",)),
    "dock": (("scene", "layout"), ("occlusion",), ("sensors", "rgbd"), ("sensors", "lidar")),
}
# One generates a whole dataset and is looked at most closely.
_COMMANDS = ("generate", "generate", "preview", "preview --check")
_QUICK_COMMANDS = ("preview", "preview --check")


def cases(stock: Stock) -> Iterator[Case]:
    """Yield the cases of recipe and rig files."""
    for base, parts in _OWN_PARTS.items():
        recipe = stock.recipe(base)
        for path, _ in leaves(recipe):
            if any(path[: len(part)] == part for part in parts):
                for mutant in mutated_leaf(recipe, path, "yaml"):
                    yield _recipe_case(base, mutant)
    for mutant in mutated_document((BASES / "rack.yaml").read_bytes(), "yaml"):
        yield _recipe_case("rack", mutant)
    yield from _rig_cases(stock.recipe("lanes")["sensors"])


def _recipe_case(base: str, mutant: Mutant) -> Case:
    # The sensors of a recipe are read by none but those that look.
    commands = _QUICK_COMMANDS[:1] if base == "lanes" and mutant.path[:1] == ("sensors",) else _COMMANDS
    command = one_of(
        commands if base != "lanes" or mutant.path[:1] == ("sensors",) else _QUICK_COMMANDS,
        base,
        mutant.where,
        mutant.mutation,
    )

    def write(folder: Path) -> None:
        (folder / "mutant.yaml").write_bytes(mutant.make())

    names = ("mutant.yaml", str(mutant.path[-1]) if mutant.path else "")
    step, check = reading(command, "mutant.yaml")
    return Case("recipe", f"{base}:{mutant.where}", mutant.mutation, (step,), write, mutant.expect, check, names)


def _rig_cases(rig: dict[str, Any]) -> Iterator[Case]:
    recipe = {
        "extends": "rack.yaml",
        "description": "The rack, seen by a rig of its own.",
        "sensors": {"rig": "rig.yaml"},
    }
    mutants = [mutant for path, _ in leaves(rig) for mutant in mutated_leaf(rig, path, "yaml")]
    mutants += mutated_document(yaml.safe_dump(rig, sort_keys=False).encode(), "yaml")
    for mutant in mutants:

        def write(folder: Path, mutant: Mutant = mutant) -> None:
            (folder / "rack.yaml").write_bytes((BASES / "rack.yaml").read_bytes())
            (folder / "recipe.yaml").write_text(yaml.safe_dump(recipe), encoding="utf-8")
            (folder / "rig.yaml").write_bytes(mutant.make())

        names = ("rig.yaml", "recipe.yaml", str(mutant.path[-1]) if mutant.path else "")
        step, check = reading("preview", "recipe.yaml")
        yield Case("rig", mutant.where, mutant.mutation, (step,), write, mutant.expect, check, names)


def reading(command: str, recipe: str) -> tuple[tuple[str, ...], Check]:
    """Return the command line that reads a recipe, and what must be true when it succeeds."""
    return {
        "preview --check": (("preview", recipe, "--check"), _numbers_are_finite),
        "preview": (("preview", recipe, "--out", "sheet.png"), _sheet_shows_something),
        "generate": (("generate", recipe, "--out", "made", "--scenes", "1", "--workers", "1"), _dataset_is_sane),
    }[command]


def _numbers_are_finite(folder: Path, outcomes: Sequence[Outcome]) -> str | None:
    words = outcomes[0].out.replace(",", " ").split()
    return "prints what is no number" if {"nan", "inf", "-inf"} & set(words) else None


def _sheet_shows_something(folder: Path, outcomes: Sequence[Outcome]) -> str | None:
    problem = image_problem(folder / "sheet.png")
    return f"the sheet {problem}" if problem else None


def _dataset_is_sane(folder: Path, outcomes: Sequence[Outcome]) -> str | None:
    problem = dataset_problem(folder / "made")
    return f"in the dataset, {problem}" if problem else None
