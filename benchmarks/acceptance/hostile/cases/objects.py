"""A user's own objects: the YAML file key by key, and mesh files of every kind of damage."""

import shutil
from collections.abc import Iterator
from pathlib import Path

import yaml

from benchmarks.acceptance.hostile.bytes_damage import damages
from benchmarks.acceptance.hostile.case import Case
from benchmarks.acceptance.hostile.cases.recipes import reading
from benchmarks.acceptance.hostile.documents import Mutant, leaves, mutated_document, mutated_leaf
from benchmarks.acceptance.hostile.draw import one_of
from benchmarks.acceptance.hostile.meshes import SHAPES, write_mesh
from benchmarks.acceptance.hostile.sane_image import image_problem
from benchmarks.acceptance.hostile.stock import Stock

_COMMANDS = ("list", "list", "preview", "generate", "preview --check")


def cases(stock: Stock) -> Iterator[Case]:
    """Yield the cases of object files and of their meshes."""
    crate = yaml.safe_load((stock.root / "crate.yaml").read_text(encoding="utf-8"))
    mutants = [mutant for path, _ in leaves(crate) for mutant in mutated_leaf(crate, path, "yaml")]
    mutants += mutated_document((stock.root / "crate.yaml").read_bytes(), "yaml")
    for mutant in mutants:
        yield _object_case(stock, mutant)
    yield from _path_cases(stock)
    for ending in ("obj", "ply", "glb"):
        for name, shape in SHAPES.items():

            def write_shape(folder: Path, name: str = name, ending: str = ending) -> None:
                _write_crate(stock, folder, ending)
                _drop_collision(folder / "crate.yaml")
                write_mesh(folder / f"crate.{ending}", name)

            # In OBJ, a negative index counts from the end.
            expect = "either" if (ending, name) == ("obj", "a negative index") else shape.expect
            for command in ("list", "generate"):
                yield _case(stock, f"crate.{ending}", name, write_shape, expect, ending, command)
        for damage in damages((stock.root / f"crate.{ending}").read_bytes(), f"crate.{ending}"):

            def write_damage(folder: Path, damage=damage, ending: str = ending) -> None:  # type: ignore[no-untyped-def]
                _write_crate(stock, folder, ending)
                damage.apply(folder / f"crate.{ending}")

            yield _case(stock, f"crate.{ending}", damage.name, write_damage, damage.expect, ending)


def _object_case(stock: Stock, mutant: Mutant) -> Case:
    def write(folder: Path) -> None:
        _write_crate(stock, folder, "obj")
        (folder / "crate.yaml").write_bytes(mutant.make())

    key = str(mutant.path[-1]) if mutant.path else ""
    return _case(stock, f"crate.yaml:{mutant.where}", mutant.mutation, write, mutant.expect, key)


def _path_cases(stock: Stock) -> Iterator[Case]:
    """Yield mesh files that lie outside of the object's folder."""
    for name, place in {
        "parent folder": "../crate.obj",
        "absolute path": str(stock.root / "crate.obj"),
        "device": "/dev/zero",
    }.items():

        def write(folder: Path, place: str = place) -> None:
            _write_crate(stock, folder, "obj")
            text = (folder / "crate.yaml").read_text(encoding="utf-8").replace("file: crate.obj", f"file: {place}")
            (folder / "crate.yaml").write_text(text, encoding="utf-8")

        yield _case(stock, "crate.yaml:file", name, write, "reject", "file")


def _write_crate(stock: Stock, folder: Path, ending: str) -> None:
    shutil.copy(stock.root / "rack.yaml", folder / "rack.yaml")
    # By its full path: within a process the catalog keeps what a name has been read as.
    recipe = (stock.root / "with_crate.yaml").read_text(encoding="utf-8").replace("crate.yaml", f"{folder}/crate.yaml")
    (folder / "with_crate.yaml").write_text(recipe, encoding="utf-8")
    text = (stock.root / "crate.yaml").read_text(encoding="utf-8").replace("crate.obj", f"crate.{ending}")
    (folder / "crate.yaml").write_text(text.replace("up: y", "up: z"), encoding="utf-8")
    shutil.copy(stock.root / f"crate.{ending}", folder / f"crate.{ending}")


def _drop_collision(path: Path) -> None:
    """Let physics take the bounding box: listed boxes would be rejected before the mesh is looked at."""
    settings = yaml.safe_load(path.read_text(encoding="utf-8"))
    del settings["collision"]
    path.write_text(yaml.safe_dump(settings, sort_keys=False), encoding="utf-8")


def _case(stock: Stock, what: str, mutation: str, write, expect, word: str, command: str = "") -> Case:  # type: ignore[no-untyped-def]
    command = command or one_of(_COMMANDS, what, mutation)
    if command == "list":
        step = ("list", "objects", "{folder}/crate.yaml", "--out", "sheet.png")

        def check(folder: Path, outcomes: object) -> str | None:
            problem = image_problem(folder / "sheet.png")
            return f"the sheet {problem}" if problem else None
    else:
        step, check = reading(command, "with_crate.yaml")  # type: ignore[assignment]
    return Case("object", what, mutation, (step,), write, expect, check, ("crate", word))
