"""Rules that turn one valid YAML or JSON document into many hostile ones: every leaf, then the whole text."""

import json
import re
from collections.abc import Callable, Iterator
from copy import deepcopy
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

import yaml

from benchmarks.acceptance.hostile.case import Expectation
from benchmarks.acceptance.hostile.quantities import Path, expectation, is_fraction

Language = Literal["yaml", "json"]
_MARK = "HOSTILE_MARK"
_DEPTH = 3000
_NUMBER = re.compile(r"-?\d{1,40}(\.\d+)?(e\+\d+)?")


@dataclass(frozen=True)
class Mutant:
    """A hostile document."""

    where: str
    """The leaf's path, or "document"."""
    mutation: str
    make: Callable[[], bytes]
    """Gives the text; there are too many to hold all."""
    expect: Expectation
    path: Path = ()
    before: Any = None
    """The leaf's value before."""


def leaves(data: Any, path: Path = ()) -> Iterator[tuple[Path, Any]]:
    """Yield the path and value of every scalar, and of every empty list or mapping."""
    if isinstance(data, (dict, list)) and data:
        for key, value in data.items() if isinstance(data, dict) else enumerate(data):
            yield from leaves(value, (*path, key))
    else:
        yield path, data


def mutated_leaf(data: Any, path: Path, language: Language) -> Iterator[Mutant]:
    """Yield the document with each hostile value at ``path``, with the key deleted, misspelt and given twice."""
    before = at(data, path)
    where = ".".join(map(str, path))
    for name, token in _values(before, path, language).items():
        make = partial(_with_token, data, path, token, language)
        yield Mutant(where, name, make, expectation(path, before, name), path, before)
    for name, change in _KEY_CHANGES.items():
        if path and (name == "deleted" or isinstance(path[-1], str)):
            make = partial(_with_change, data, path, change, language)
            yield Mutant(where, name, make, expectation(path, before, name), path, before)


def mutated_document(content: bytes, language: Language) -> Iterator[Mutant]:
    """Yield what can happen to a whole text file: nesting, digits, aliases, encodings, bytes of something else."""
    whole: dict[str, tuple[bytes, Expectation]] = {
        "empty file": (b"", "reject"),
        "one scalar": (b"7", "reject"),
        "a list": (b"[1, 2, 3]", "reject"),
        "binary": (bytes(range(256)) * 16, "reject"),
        "UTF-16": (content.decode().encode("utf-16-le"), "reject"),
        "a byte that is no UTF-8": (content.replace(b":", b": \xff", 1), "reject"),
        "first half": (content[: len(content) // 2], "either"),
        "nested 3,000 deep": (b"[" * _DEPTH + b"]" * _DEPTH, "reject"),
        "nested mappings": (b'{"a": ' * _DEPTH + b"1" + b"}" * _DEPTH, "reject"),
        "control bytes": (content.replace(b":", b":\x00", 1), "reject"),
        "an integer of 5,001 digits": (b"9" * 5001, "reject"),
    }
    if language == "yaml":
        whole |= _yaml_documents(content)
    for name, (text, expect) in whole.items():
        yield Mutant("document", name, partial(bytes, text), expect)


def _yaml_documents(content: bytes) -> dict[str, tuple[bytes, Expectation]]:
    rows = [b"a0: &a0 [x, x, x, x, x, x, x, x, x]"]
    rows += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]".encode() for i in range(1, 9)]
    return {
        "UTF-8 mark": (b"\xef\xbb\xbf" + content, "accept"),
        "blank lines at the end": (content + b"\n\n\n", "accept"),
        "Windows line ends": (content.replace(b"\n", b"\r\n"), "accept"),
        "a comment before": ("# größer\n".encode() + content, "accept"),
        "aliases of aliases": (b"\n".join(rows) + b"\n" + content, "reject"),
        "an alias of itself": (b"&a [*a]", "reject"),
        "a Python tag": (b"description: !!python/object/apply:os.getcwd []\n", "reject"),
        "two documents": (content + b"\n---\n" + content, "reject"),
        "tabs": (content.replace(b"  ", b"\t"), "reject"),
        "a nested key": (b"description: " + b"[" * _DEPTH + b"]" * _DEPTH + b"\n" + content, "reject"),
        "keys that are no words": (b"1: 2\nnull: 3\n" + content, "reject"),
        "a list as key": (b"? [1, 2]\n: 3\n" + content, "reject"),
        "a merge key": (b"<<: [1]\n" + content, "reject"),
        "a date": (b"scenes: 2020-01-01\n", "reject"),
    }


def at(data: Any, path: Path) -> Any:
    """Return what is at ``path``."""
    for key in path:
        data = data[key]
    return data


def _values(before: Any, path: Path, language: Language) -> dict[str, str]:
    json_names = {"nan": "NaN", "inf": "Infinity", "minus_inf": "-Infinity"}
    yaml_names = {"nan": ".nan", "inf": ".inf", "minus_inf": "-.inf"}
    number = before if isinstance(before, (int, float)) and not isinstance(before, bool) else None
    whole = isinstance(number, int)
    values = {
        **(json_names if language == "json" else yaml_names),
        "negative": str(-abs(number)) if number else "-1",
        "zero": "0",
        "e9": "1000000000" if whole else "1.0e+9",
        "e300": "1.0e+300",
        "huge_integer": "9" * 30,
        "digits_5001": "9" * 5001,
        "string": '"seven"',
        "list": "[1, 2]",
        "mapping": '{"a": 1}',
        "null": "null",
        "true": "true",
        "empty": '""',
    }
    if whole:
        values["fraction"] = f"{number + 0.5}"
    if is_fraction(path):
        values["above_one"] = "1.5"
    return {name: token for name, token in values.items() if not _same(token, before)}


def _same(token: str, before: Any) -> bool:
    """Return whether a token means the value that is there already."""
    if isinstance(before, (int, float)) and not isinstance(before, bool):
        return bool(_NUMBER.fullmatch(token)) and float(token) == before
    return token == json.dumps(before)


def _dump(data: Any, language: Language) -> str:
    if language == "json":
        return json.dumps(data, indent=1)
    return yaml.safe_dump(data, sort_keys=False, width=10**6, allow_unicode=True)


def _with_token(data: Any, path: Path, token: str, language: Language) -> bytes:
    text = _dump(_put(data, path, _MARK), language)
    return text.replace(f'"{_MARK}"' if language == "json" else _MARK, token).encode()


def _with_change(data: Any, path: Path, change: Callable[[Any, Path], Any], language: Language) -> bytes:
    return _dump(change(data, path), language).replace(_MARK, str(path[-1])).encode()


def _put(data: Any, path: Path, value: Any) -> Any:
    changed = deepcopy(data)
    if not path:
        return value
    at(changed, path[:-1])[path[-1]] = value
    return changed


def _deleted(data: Any, path: Path) -> Any:
    changed = deepcopy(data)
    del at(changed, path[:-1])[path[-1]]
    return changed


def _misspelt(data: Any, path: Path) -> Any:
    key = str(path[-1])
    wrong = key[:-1] if len(key) > 3 else f"{key}x"
    return _put(data, path[:-1], _renamed(at(data, path[:-1]), key, wrong))


def _duplicated(data: Any, path: Path) -> Any:
    parent = at(data, path[:-1])
    return _put(data, path[:-1], {**parent, _MARK: parent[path[-1]]})


def _renamed(mapping: dict[str, Any], key: str, wrong: str) -> dict[str, Any]:
    return {wrong if name == key else name: value for name, value in mapping.items()}


_KEY_CHANGES: dict[str, Callable[[Any, Path], Any]] = {
    "deleted": _deleted,
    "misspelt": _misspelt,
    "duplicated": _duplicated,
}
