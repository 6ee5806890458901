"""Datasets: every leaf of every table, every line of every text file, every kind of damage to every binary file."""

import json
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

from benchmarks.acceptance.hostile.bytes_damage import Damage, damages, replace
from benchmarks.acceptance.hostile.case import Case, Expectation
from benchmarks.acceptance.hostile.documents import Mutant, leaves, mutated_document, mutated_leaf
from benchmarks.acceptance.hostile.draw import one_of, stream
from benchmarks.acceptance.hostile.readings import dataset_reading
from benchmarks.acceptance.hostile.stock import Stock


@dataclass(frozen=True)
class _Table:
    """A JSON file of a dataset, and which of its values others read: any change of them must be noticed."""

    file: str
    read: str
    """Regular expression of the paths whose values mean the same to every reader; the rest is there for people."""
    optional: str = r"(?!)"
    """Keys that may be left out."""
    validated_alone: bool = False
    """Whether no command but ``validate`` reads it."""


_TABLES = (
    _Table(
        "manifest.json",
        r"^(seed|scenes|observations_per_scene|splits|formats|targets|format_version)",
    ),
    _Table("objects.json", r".", r"pockets$"),
    _Table("bop/camera.json", r"."),
    _Table("bop/models/models_info.json", r"."),
    _Table("bop/models_eval/models_info.json", r"."),
    _Table("bop/test/{test}/scene_gt.json", r"."),
    _Table("bop/test/{test}/scene_gt_info.json", r"."),
    _Table("bop/test/{test}/scene_camera.json", r"."),
    _Table("bop/test/{test}/scene_gt_coco.json", r"^(images|annotations)", r"^(info|licenses)|width$|height$", True),
    _Table("bop/test_targets_bop19.json", r"."),
    _Table("bop/test_targets_bop24.json", r"."),
    _Table(
        "scenes/{test}.json",
        r"^(scene_index|seed|split|renderer)|T_world_(camera|object)|^(?!tally).*(instance_id|obj_id|class_name)",
    ),
)
_LEAVES_A_SHAPE = 2
_NOTHING = 4e-7
"""Entries of a rotation that are smaller may be zero or of the other sign: products of rows change by less than 1e-6,
to which files say that a matrix is one."""
# What reads a dataset, and how often it is chosen.
_COMMANDS = ("validate",) * 6 + ("evaluate",) * 4 + ("predict",) * 2 + ("report", "train")
_TEXT = ("kitti/testing/label_2", "kitti/testing/calib", "kitti/testing/planes", "kitti/ImageSets")


def cases(stock: Stock) -> Iterator[Case]:
    """Yield the cases of dataset files."""
    test = sorted(path.name for path in (stock.data / "bop" / "test").iterdir())[0]
    for table in _TABLES:
        file = table.file.format(test=test)
        yield from _table_cases(stock, table, file, json.loads((stock.data / file).read_text(encoding="utf-8")))
    for folder in _TEXT:
        for path in sorted((stock.data / folder).iterdir())[:4]:
            yield from _line_cases(stock, str(path.relative_to(stock.data)))
    yield from _file_cases(stock)
    yield from _zero_cases(stock)
    yield from _geometry_cases(stock, f"bop/test/{test}/scene_gt.json")


def _table_cases(stock: Stock, table: _Table, file: str, data: Any) -> Iterator[Case]:
    commands = ("validate",) if table.validated_alone else _COMMANDS
    for path in _chosen_leaves(data, file):
        where = ".".join(map(str, path))
        strict = re.search(table.read, where)
        for mutant in mutated_leaf(data, path, "json"):
            yield _mutant_case(stock, file, mutant, _expected(mutant, bool(strict), table, where), commands)
    for mutant in mutated_document((stock.data / file).read_bytes(), "json"):
        yield _mutant_case(stock, file, mutant, mutant.expect, commands)


def _expected(mutant: Mutant, strict: bool, table: _Table, where: str) -> Expectation:
    """Return what must happen: who reads a value must notice that it is another one, whatever else is right."""
    if mutant.mutation == "duplicated" or re.search(table.optional, where):
        return "either"  # JSON's parsers take the last of two, here the same value
    if mutant.mutation in ("nan", "inf", "minus_inf", "digits_5001"):
        return "reject"  # no JSON, and more digits than Python's reader takes
    if mutant.mutation in ("negative", "zero") and "cam_R_" in where and abs(mutant.before) < _NOTHING:
        return "either"
    if mutant.mutation == "negative" and isinstance(mutant.before, (int, float)) and mutant.before < 0:
        return "either"  # it was negative before: nothing is changed
    return "reject" if strict else "either"


def _chosen_leaves(data: Any, file: str) -> Iterator[tuple[str | int, ...]]:
    """Yield the first leaf and a drawn one of all that differ in nothing but positions in lists and numbered keys."""

    def shape(path: tuple[str | int, ...]) -> tuple[str, ...]:
        return tuple("*" if isinstance(key, int) or key.isdecimal() else key for key in path)

    paths = sorted(
        (path for path, _ in leaves(data)), key=lambda path: (shape(path), [str(key).zfill(9) for key in path])
    )
    for of, group in groupby(paths, key=shape):
        alike = list(group)
        yield alike[0]
        yield from stream(file, of).sample(alike[1:], min(len(alike) - 1, _LEAVES_A_SHAPE - 1))


def _mutant_case(stock: Stock, file: str, mutant: Mutant, expect: Expectation, commands: tuple[str, ...]) -> Case:
    def write(folder: Path) -> None:
        replace(stock.copy_data(folder) / file, mutant.make())

    return _case(stock, f"{file}:{mutant.where}", mutant.mutation, write, expect, file, commands)


def _line_cases(stock: Stock, file: str) -> Iterator[Case]:
    """Yield a text file with each word of each line (of one line a shape) replaced, and with damage as a whole."""
    text = (stock.data / file).read_text(encoding="ascii")
    lines = text.splitlines()
    for number, line in enumerate(lines[:12]):
        words = line.split(" ")
        for position in range(len(words)):
            for name, value in {
                "nan": "nan",
                "inf": "inf",
                "negative": "-7.5",
                "e300": "1e300",
                "string": "seven",
                "deleted": None,
            }.items():
                changed = [*words[:position], *([] if value is None else [value]), *words[position + 1 :]]
                yield _text_case(
                    stock,
                    file,
                    f"{number + 1}.{position + 1}",
                    name,
                    [*lines[:number], " ".join(changed), *lines[number + 1 :]],
                )
        yield _text_case(stock, file, f"{number + 1}", "line deleted", [*lines[:number], *lines[number + 1 :]])
        yield _text_case(stock, file, f"{number + 1}", "line twice", [*lines[: number + 1], *lines[number:]])


def _text_case(stock: Stock, file: str, where: str, mutation: str, lines: list[str]) -> Case:
    def write(folder: Path) -> None:
        replace(stock.copy_data(folder) / file, "".join(f"{line}\n" for line in lines).encode())

    # The heading of a plane and the place of an inertial sensor that there is not are read by nobody.
    unread = ("planes" in file and not where.startswith("4")) or ("calib" in file and where.startswith("7"))
    return _case(stock, f"{file}:{where}", mutation, write, "either" if unread else "reject", file, ("validate",))


def _file_cases(stock: Stock) -> Iterator[Case]:
    """Yield every kind of damage to one file of each folder, and to that file of the dataset of a rig."""
    for data in (stock.data, stock.rig_data):
        folders = sorted({path.parent for path in data.rglob("*") if path.is_file() and path.suffix != ".json"})
        for folder in folders:
            path = sorted(item for item in folder.iterdir() if item.is_file())[0]
            file = str(path.relative_to(data))
            rig = data == stock.rig_data
            for damage in (*damages(path.read_bytes(), file, _body(path)), *_swaps(path)):
                yield _damage_case(stock, data, file, damage, ("validate",) if rig else _COMMANDS)


def _body(path: Path) -> Expectation:
    """Return what must happen when a bit is flipped: text and compressed images show it, numbers may be others."""
    if path.suffix == ".md" or path.suffix == ".bin":
        return "either"
    return "reject"


def _swaps(path: Path) -> Iterator[Damage]:
    """Yield another file of the same kind, and one of another kind, in the file's place."""
    others = [
        item for item in sorted(path.parent.iterdir()) if item.is_file() and item.read_bytes() != path.read_bytes()
    ]
    if others:
        content = others[-1].read_bytes()
        yield Damage("its neighbour in its place", lambda target: replace(target, content), "reject")


def _damage_case(stock: Stock, data: Path, file: str, damage: Damage, commands: tuple[str, ...]) -> Case:
    def write(folder: Path) -> None:
        damage.apply(stock.copy_data(folder, data) / file)

    # Notes and pictures for people mean nothing to a reader, and ``validate --regenerate`` reads lists of checksums.
    apart = file.endswith((".md", "SHA256SUMS")) or file.startswith("card/")
    expect: Expectation = "either" if apart else damage.expect
    what = file if data == stock.data else f"rig/{file}"
    return _case(stock, what, damage.name, write, expect, file, commands)


def _zero_cases(stock: Stock) -> Iterator[Case]:
    """Yield what is well formed and says nothing: numbers that are all zero."""
    for kind in ("velodyne", "velodyne_ids", "velodyne_beams"):
        file = (
            f"kitti/testing/{kind}/{sorted(path.name for path in (stock.data / 'kitti/testing' / kind).iterdir())[0]}"
        )

        def write(folder: Path, file: str = file) -> None:
            path = stock.copy_data(folder) / file
            replace(path, bytes(path.stat().st_size))

        yield _case(stock, file, "all zero", write, "reject", file, ("validate",))


def _geometry_cases(stock: Stock, poses: str) -> Iterator[Case]:
    """Yield geometry that cannot be and that scores depend on: who scores must see it without ``validate``."""
    # With the pallet's own half turn they are a group, but a pallet upside down is another sight.
    half_turns = [[[s, 0, 0, 0], [0, -s, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]] for s in (1, -1)]
    changes: dict[str, tuple[str, Callable[[Any], None]]] = {
        "diameter ten times": ("objects.json", lambda data: data["1"].update(diameter=10 * data["1"]["diameter"])),
        "diameter 0": ("objects.json", lambda data: data["1"].update(diameter=0.0)),
        "diameter -1": ("objects.json", lambda data: data["1"].update(diameter=-1.0)),
        "a false symmetry": ("objects.json", lambda data: data["1"]["symmetries"].extend(half_turns)),
        "the identity is missing": ("objects.json", lambda data: data["1"]["symmetries"].pop(0)),
        "no pockets": ("objects.json", lambda data: data["1"].update(pockets=[])),
        "a pocket's face is +q": ("objects.json", lambda data: data["1"]["pockets"][0].update(face="+q")),
        "a pocket 10 m wide": ("objects.json", lambda data: data["1"]["pockets"][0].update(size=[1.2, 10.0, 0.1])),
        "behind the camera": (poses, lambda data: data["0"][0]["cam_t_m2c"].__setitem__(2, -3000.0)),
        "in the camera": (poses, lambda data: data["0"][0].update(cam_t_m2c=[0.0, 0.0, 0.0])),
    }
    evaluate = dataset_reading(stock, "evaluate")[0][:1]
    for name, (file, change) in changes.items():

        def write(folder: Path, file: str = file, change: Callable[[Any], None] = change) -> None:
            data = json.loads((stock.data / file).read_text(encoding="utf-8"))
            change(data)
            replace(stock.copy_data(folder) / file, json.dumps(data).encode())

        yield _case(stock, file, name, write, "reject", file, ("validate",))
        if name != "no pockets":  # the file alone does not say that there should be any
            yield Case("dataset", file, name, evaluate, write, "reject", names=(Path(file).name, "data"))


def _case(
    stock: Stock,
    what: str,
    mutation: str,
    write: Any,
    expect: Expectation,
    file: str,
    commands: tuple[str, ...] = _COMMANDS,
) -> Case:
    command = one_of(commands, what, mutation)
    steps, check = dataset_reading(stock, command, what.startswith("rig/"))
    path = Path(file)
    names = (path.name, path.stem, path.parent.name, str(path.parent.parent.name), "data")
    return Case("dataset", what, mutation, steps, write, expect, check, names)
