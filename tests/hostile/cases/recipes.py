"""Recipes, rigs, objects and meshes: every setting of four base recipes that together hold nearly all there are."""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
import yaml

import warehouse_sim as ws
from tests.hostile.case import Case, Check, Expectation, Outcome, Step, one_of
from tests.hostile.mutants import OF_A_DISTRIBUTION, Mutant, leaves, mutants, mutated_bytes, mutated_leaf, mutated_text
from tests.hostile.sane import dataset_problem, image_problem
from tests.hostile.stock import BASES, CRATE, RACK, Stock

# Of each base, the parts in which it differs from the others; the first is mutated as a whole.
_OWN_PARTS: dict[str, tuple[tuple[str, ...], ...]] = {
    "rack": ((),),
    "lanes": (("scene", "layout"), ("scene", "lights"), ("scene", "traffic"), ("scene", "lanes"), ("sensors",)),
    "drive": (("scene", "layout"), ("scene", "viewpoints"), ("paired_variants",)),
    "dock": (("scene", "layout"), ("occlusion",), ("sensors", "rgbd"), ("sensors", "lidar")),
}
_CRATE_SCENE = {"targets": ["pallet", "crate"], "traffic": {"objects": ["crate.yaml"], "own": 2}}
_CRATE_RECIPE = yaml.safe_dump({"extends": str(RACK), "description": "With a crate.", "scene": _CRATE_SCENE}).encode()
_RIG_RECIPE = yaml.safe_dump({"extends": str(RACK), "description": "A rig.", "sensors": {"rig": "rig.yaml"}}).encode()
# One generates a whole dataset and is looked at most closely; ``settings`` gives Python the same as ``settings=``.
_READERS = ("generate", *("check",) * 4, *("settings",) * 3, "preview")


def cases(stock: Stock) -> Iterator[Case]:
    """Yield the cases of recipe, rig, object and mesh files."""
    for base, parts in _OWN_PARTS.items():
        settings = ws.recipe(BASES / f"{base}.yaml").settings
        for path, _ in islice(leaves(settings), 0, None, stock.every):
            if any(path[: len(part)] == part for part in parts):
                for mutant in mutated_leaf(settings, path, ".yaml"):
                    yield _recipe_case(base, mutant)
    for mutant in (*mutated_text(RACK.read_bytes(), ".yaml"), *mutated_bytes(RACK.read_bytes(), "rack.yaml")):
        yield _recipe_case("rack", mutant)
    rig = ws.recipe(BASES / "lanes.yaml").settings["sensors"]
    for mutant in islice(mutants(yaml.safe_dump(rig, sort_keys=False).encode(), "rig.yaml"), 0, None, stock.every):
        step, check = _reading(one_of(("preview", "read", "read"), mutant.where, mutant.mutation), "recipe.yaml")
        write = partial(_write, {"recipe.yaml": _RIG_RECIPE}, {"rig.yaml": mutant})
        names = ("rig.yaml", "recipe.yaml", *map(str, mutant.path[-1:]))
        kind = "call recipe" if callable(step) else "recipe"
        yield Case(kind, f"rig:{mutant.where}", mutant.mutation, (step,), write, mutant.expect, check, names)
    yield from _object_cases(stock)


def _recipe_case(base: str, mutant: Mutant) -> Case:
    reader = one_of(_READERS, base, mutant.where, mutant.mutation)
    reader = "preview" if base == "lanes" and reader == "generate" else reader
    names = ("mutant.yaml", *map(str, mutant.path))
    step, check = _reading(reader, "mutant.yaml")
    expect = mutant.expect
    if reader == "settings" and mutant.path and mutant.mutation not in ("digits_5001", "duplicated"):
        step = partial(with_settings, BASES / f"{base}.yaml", mutant.make)
        if mutant.mutation == "deleted":  # what is not given stays, but a list or a distribution must be whole
            last = mutant.path[-1]
            expect = "either" if isinstance(last, int) or last in OF_A_DISTRIBUTION else "accept"
    kind = "call recipe" if callable(step) else "recipe"
    write = partial(_write, {}, {"mutant.yaml": mutant})
    return Case(kind, f"{base}:{mutant.where}", mutant.mutation, (step,), write, expect, check, names)


def _object_cases(stock: Stock) -> Iterator[Case]:
    content = yaml.safe_dump(CRATE, sort_keys=False).encode()
    for mutant in mutants(content, "crate.yaml"):
        yield _object_case(stock, "crate.yaml", mutant, {"crate.yaml": mutant})
    places = {"parent folder": "../crate.obj", "absolute path": str(stock.root / "crate.obj"), "device": "/dev/zero"}
    for name, place in places.items():
        mutant = Mutant("file", name, partial(bytes, yaml.safe_dump({**CRATE, "file": place}).encode()), "reject")
        yield _object_case(stock, "crate.yaml", mutant, {"crate.yaml": mutant})
    # Without collision boxes physics takes the bounding box: listed ones would be rejected before the mesh is read.
    plain = {key: value for key, value in CRATE.items() if key != "collision"}
    for ending in ("obj", "ply", "glb"):
        file = f"crate.{ending}"
        crate = Mutant("", "", partial(bytes, yaml.safe_dump({**plain, "file": file}).encode()), "accept")
        bodies = _meshes(ending) if ending != "glb" else ()
        for mutant in (*bodies, *mutated_bytes((stock.root / file).read_bytes(), file)):
            yield _object_case(stock, file, mutant, {"crate.yaml": crate, file: mutant})


def _object_case(stock: Stock, file: str, mutant: Mutant, files: dict[str, Mutant]) -> Case:
    reader = one_of(("list", "check", "add", "add", "generate"), file, mutant.where, mutant.mutation)
    step, check = _reading(reader, "with_crate.yaml")
    write = partial(_write_crate, stock, files)
    kind, names = "call object" if callable(step) else "object", ("crate", mutant.where.rpartition(".")[2])
    return Case(kind, f"{file}:{mutant.where}", mutant.mutation, (step,), write, mutant.expect, check, names)


def _write_crate(stock: Stock, hostile: dict[str, Mutant], folder: Path) -> None:
    valid = {name: (stock.root / name).read_bytes() for name in ("crate.obj", "crate.ply", "crate.glb")}
    _write({"with_crate.yaml": _CRATE_RECIPE, **valid}, hostile, folder)


def _write(valid: dict[str, bytes], hostile: dict[str, Mutant], folder: Path) -> None:
    for name, content in valid.items():
        (folder / name).write_bytes(content)
    for name, mutant in hostile.items():
        mutant.apply(folder / name)


def _reading(reader: str, recipe: str) -> tuple[Step, Check | None]:
    """Return a step that reads a recipe or an object, and what must be true when it succeeds."""
    made: dict[str, tuple[Step, Check | None]] = {
        "check": (("preview", recipe, "--check"), _numbers_are_finite),
        "preview": (("preview", recipe, "--out", "sheet.png"), sheet_shows_something),
        "generate": (("generate", recipe, "--out", "made", "--scenes", "1", "--workers", "1"), dataset_is_sane),
        "list": (("list", "objects", "crate.yaml", "--out", "sheet.png"), sheet_shows_something),
        "settings": (partial(with_settings, recipe, None), None),
        "read": (partial(ws.recipe, recipe), None),
        "add": (partial(add_object, "crate.yaml"), None),
    }
    return made[reader]


def with_settings(recipe: str | Path, make: Callable[[], Any] | None) -> str:
    """Read a recipe in Python, some settings replaced, write it, read it again, and let a scene of it settle."""
    made = ws.recipe(recipe, settings=None if make is None else yaml.safe_load(make()))
    made.save("saved.yaml")
    again = ws.recipe("saved.yaml")
    assert again.settings == made.settings, "the recipe that was saved is another one"
    return repr(ws.Scene(again).settle())


def add_object(file: str) -> str:
    """Put an object of one's own into an empty hall and let it settle."""
    scene = ws.Scene()
    scene.add(file)
    return repr(scene.settle())


def _numbers_are_finite(folder: Path, outcomes: Sequence[Outcome]) -> str | None:
    words = outcomes[0].out.replace(",", " ").split()
    return "prints what is no number" if {"nan", "inf", "-inf"} & set(words) else None


def sheet_shows_something(folder: Path, outcomes: Sequence[Outcome]) -> str | None:
    """Find a contact sheet that cannot be decoded or is blank."""
    return image_problem(folder / "sheet.png")


def dataset_is_sane(folder: Path, outcomes: Sequence[Outcome]) -> str | None:
    """Find a fault in a generated dataset: one that ``validate`` names, or what cannot be in a warehouse."""
    wrong = [f"validate says {check.name}: {check.detail}" for check in ws.validate(folder / "made") if not check.ok]
    return wrong[0] if wrong else dataset_problem(folder / "made")


def _meshes(ending: str) -> Iterator[Mutant]:
    """Yield valid files, OBJ or PLY, of impossible or unwieldy bodies."""
    box = trimesh.creation.box(extents=(0.4, 0.3, 0.2))
    vertices, faces = np.asarray(box.vertices), np.asarray(box.faces)
    near = np.arange(vertices.size).reshape(vertices.shape) != 10
    first = np.arange(faces.size).reshape(faces.shape) != 7
    bodies: dict[str, tuple[np.ndarray, np.ndarray, Expectation]] = {
        "as it is": (vertices, faces, "accept"),
        "a vertex is NaN": (np.where(near, vertices, np.nan), faces, "reject"),
        "a vertex is infinite": (np.where(near, vertices, np.inf), faces, "reject"),
        "a vertex 1e30 m away": (np.where(near, vertices, 1e30), faces, "reject"),
        "an index out of range": (vertices, np.where(first, faces, 999), "reject"),
        "a negative index": (vertices, np.where(first, faces, -5), "either"),  # which counts from the end in OBJ
        "one triangle": (vertices[:3], np.array([[0, 1, 2]]), "reject"),
        "no triangle": (vertices, faces[:0], "reject"),
        "no vertex": (vertices[:0], faces[:0], "reject"),
        "zero area": (vertices, 0 * faces, "reject"),
        "triangles of two corners": (vertices, faces[:, [0, 1, 1]], "reject"),
        "flat": (vertices * [1, 1, 0], faces, "either"),
        "a line": (vertices * [1, 0, 0], faces, "reject"),
        "a point": (vertices * 0, faces, "reject"),
        "400 m long": (vertices * 1000, faces, "reject"),
        "0.4 mm long": (vertices * 0.001, faces, "reject"),
        "inside out": (vertices, faces[:, ::-1], "accept"),
        "half inside out": (vertices, np.vstack([faces[:6], faces[6:, ::-1]]), "either"),
        "every face twice": (vertices, np.vstack([faces, faces]), "either"),
        "a side is missing": (vertices, faces[2:], "either"),
    }
    for name, (points, corners, expect) in bodies.items():
        if ending == "obj":
            head, before, corners = "o crate\n", ("v ", "f "), corners + 1
        else:
            head = f"ply\nformat ascii 1.0\nelement vertex {len(points)}\n" + "".join(
                map("property float {}\n".format, "xyz")
            )
            head += f"element face {len(corners)}\nproperty list uchar int vertex_indices\nend_header\n"
            before = ("", "3 ")
        rows = [
            mark + " ".join(map(str, row)) for mark, part in zip(before, (points, corners), strict=True) for row in part
        ]
        yield Mutant("", name, partial(bytes, (head + "\n".join(rows) + "\n").encode()), expect)
