"""Rules that turn one valid file into many hostile ones: every leaf or word, the whole text, the bytes, the file."""

import json
import os
import re
from collections.abc import Callable, Iterator
from copy import deepcopy
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Any

import yaml

from tests.hostile.case import Expectation, stream

Place = tuple[str | int, ...]
Making = Callable[[], bytes | Callable[[Path], Any]]
"""Gives the hostile bytes, or what puts something else than a file in its place; there are too many to hold all."""
_MARK = "HOSTILE_MARK"
_DEPTH = 3000
_LINES, _WORDS_A_LINE = 12, 16

# What the words of a setting's name say of its values; nothing here knows the product's ranges.
# Places, turns and differences have two signs; all else in a warehouse is an amount.
_SIGNED = re.compile(
    r"yaw|pitch_deg|roll|elevation|approach_deg|offset|heading|lateral|depth_mm|shift_mm|azimuth|bearing|position|centre"
    r"|^(forward|left|up|overhang_mm|c[xy]|[kp]\d|direction|velocity|bias|mean)$|_ev$|^(T|cam)_|rotation|translation"
    r"|centroid|covariance|symmetries|location|alpha|white_balance"
)
# The light of a hall is given as a fraction of that in its aisle, and may be more.
_FRACTION = re.compile(
    r"^(?!hall_fraction$).*fraction|probability|^(train|val|test|age|missing|broken|displaced|twisted|stains|stamps|fill)$"
)
# Without any of these there is no image, no rack, no truck: zero means nothing.
_NEVER_ZERO = re.compile(
    r"^(width|focal_px|bays|lanes|doors|segments|scenes|observations_per_scene|aisle_width|bay_width|lane_width|pallet_width"
    r"|pallets_per_bay|stack_pitch|baseline|turns_per_second|every_nth_beam|scale|fx|fy|depth_scale|diameter"
    r"|max_time|obj_id|size|size_[xyz]|side_px|batch)$"
)
_FREE_TEXT = re.compile(r"^(description|name|class_name|version|torch|device|sha256)$")
# Relative weights and spreads that bounds cut off mean something at any size; a seed is any whole number.
_ANY_SIZE = re.compile(r"^(weights|std|seed)$")
OF_A_DISTRIBUTION = frozenset({"min", "max", "mean", "std", "choices"})
NO_JSON = frozenset({"nan", "inf", "minus_inf", "digits_5001"})
_HUGE = frozenset({"e9", "e300", "huge_integer", "digits_5001"})
_OTHER_TYPE = frozenset({"string", "list", "mapping", "true", "empty"})
_WORDS: dict[str, str | None] = {
    "nan": "nan",
    "inf": "inf",
    "negative": "-7.5",
    "e300": "1e300",
    "huge_integer": "9" * 30,
    "digits_5001": "9" * 5001,
    "string": "seven",
    "underscores": "1_0",
    "other digits": "٣",
    "deleted": None,
}


@dataclass(frozen=True)
class Mutant:
    """A hostile file."""

    where: str
    """Path of the leaf, line and word, or "document"."""
    mutation: str
    make: Making
    expect: Expectation
    path: Place = ()
    before: Any = None
    """The leaf's value before."""

    def apply(self, path: Path) -> None:
        """Put it in the place of a file, which may be shared with a link."""
        made = self.make()
        path.parent.mkdir(parents=True, exist_ok=True)
        path.unlink(missing_ok=True)
        if isinstance(made, bytes):
            path.write_bytes(made)
        else:
            made(path)


def mutants(content: bytes, name: str, body: Expectation = "either") -> Iterator[Mutant]:
    """Yield what can happen to a file.

    Args:
        content: The valid bytes.
        name: Its name, whose ending says what it holds; also decides which bits are flipped.
        body: What must happen where bits of the body are flipped.
    """
    ending = Path(name).suffix
    if ending in (".json", ".yaml"):
        data = json.loads(content) if ending == ".json" else yaml.safe_load(content)
        for path in _chosen_leaves(data, name):
            yield from mutated_leaf(data, path, ending)
        yield from mutated_text(content, ending)
    elif ending in (".txt", ".csv"):
        yield from _mutated_lines(content.decode())
    yield from mutated_bytes(content, name, "either" if ending in (".json", ".yaml") else body)


def leaves(data: Any, path: Place = ()) -> Iterator[tuple[Place, Any]]:
    """Yield the path and value of every scalar, and of every empty list or mapping."""
    if isinstance(data, (dict, list)) and data:
        for key, value in data.items() if isinstance(data, dict) else enumerate(data):
            yield from leaves(value, (*path, key))
    else:
        yield path, data


def _chosen_leaves(data: Any, name: str) -> Iterator[Place]:
    """Yield the first leaf and a drawn one of all that differ in nothing but positions in lists and numbered keys."""

    def shape(path: Place) -> tuple[str, ...]:
        return tuple("*" if isinstance(key, int) or key.isdecimal() else key for key in path)

    paths = sorted((path for path, _ in leaves(data)), key=lambda path: (shape(path), str(path)))
    for of, group in groupby(paths, shape):
        alike = list(group)
        yield alike[0]
        yield from stream(name, of).sample(alike[1:], min(len(alike) - 1, 1))


def mutated_leaf(data: Any, path: Place, ending: str) -> Iterator[Mutant]:
    """Yield the document with each hostile value at ``path``, with the key deleted, misspelt and given twice."""
    before, where = at(data, path), ".".join(map(str, path))
    for name, token in _values(before, path, ending).items():
        make = partial(_with_token, data, path, token, ending)
        yield Mutant(where, name, make, _expectation(path, before, name), path, before)
    for name in ("deleted", "misspelt", "duplicated"):
        if path and (name == "deleted" or isinstance(path[-1], str)):
            make = partial(_with_key, data, path, name, ending)
            yield Mutant(where, name, make, _expectation(path, before, name), path, before)


def _expectation(path: Place, value: Any, mutation: str) -> Expectation:
    """Return what must happen when the setting at ``path``, which was ``value``, gets the value called ``mutation``."""
    words = [word for word in path if isinstance(word, str)]
    last = words[-1] if words else ""
    if mutation in ("misspelt", "duplicated"):
        return "reject"
    if isinstance(value, str):
        return "either" if _FREE_TEXT.search(last) or mutation in ("deleted", "null") else "reject"
    if isinstance(value, bool):
        return "either" if mutation in ("true", "deleted", "null") else "reject"
    if mutation in NO_JSON or (mutation in _HUGE and not _ANY_SIZE.search(last)):
        return "reject"
    if value is None:
        return "either"
    must = {
        "negative": value != 0 and not any(map(_SIGNED.search, words)),
        "zero": bool(_NEVER_ZERO.search(last)),
        "fraction": isinstance(value, int) and last != "weights",
        "above_one": _is_fraction(path),
    }
    return "reject" if must.get(mutation, mutation in _OTHER_TYPE) else "either"


def _is_fraction(path: Place) -> bool:
    words = [word for word in path if isinstance(word, str) and word not in OF_A_DISTRIBUTION]
    return bool(words and _FRACTION.search(words[-1]))


def mutated_text(content: bytes, ending: str) -> Iterator[Mutant]:
    """Yield what can happen to a whole document: nesting, digits, aliases, encodings."""
    wrong: dict[str, bytes] = {
        "one scalar": b"7",
        "a list": b"[1, 2, 3]",
        "UTF-16": content.decode().encode("utf-16-le"),
        "a byte that is no UTF-8": content.replace(b":", b": \xff", 1),
        "nested 3,000 deep": b"[" * _DEPTH + b"]" * _DEPTH,
        "nested mappings": b'{"a": ' * _DEPTH + b"1" + b"}" * _DEPTH,
        "control bytes": content.replace(b":", b":\x00", 1),
        "an integer of 5,001 digits": b"9" * 5001,
    }
    right: dict[str, bytes] = {}
    if ending == ".yaml":
        rows = [b"a0: &a0 [x, x, x, x, x, x, x, x, x]"]
        rows += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]".encode() for i in range(1, 9)]
        wrong |= {
            "aliases of aliases": b"\n".join(rows) + b"\n" + content,
            "an alias of itself": b"&a [*a]",
            "a Python tag": b"description: !!python/object/apply:os.getcwd []\n",
            "two documents": content + b"\n---\n" + content,
            "tabs": content.replace(b"  ", b"\t"),
            "a nested key": b"description: " + b"[" * _DEPTH + b"]" * _DEPTH + b"\n" + content,
            "keys that are no words": b"1: 2\nnull: 3\n" + content,
            "a list as key": b"? [1, 2]\n: 3\n" + content,
            "a merge key": b"<<: [1]\n" + content,
            "a date": b"scenes: 2020-01-01\n",
        }
        right = {
            "UTF-8 mark": b"\xef\xbb\xbf" + content,
            "blank lines at the end": content + b"\n\n\n",
            "Windows line ends": content.replace(b"\n", b"\r\n"),
            "a comment before": "# größer\n".encode() + content,
        }
    for texts, expect in ((wrong, "reject"), (right, "accept")):
        for name, text in texts.items():
            if text != content:
                yield Mutant("document", name, partial(bytes, text), expect)  # type: ignore[arg-type]


def _mutated_lines(text: str) -> Iterator[Mutant]:
    """Yield a table with each word of each line replaced, and with lines deleted or given twice."""
    lines = text.splitlines(keepends=True)
    for number, line in enumerate(lines[:_LINES]):
        words = re.split(r"([ ,\n])", line)
        changes = {("line deleted", ""): "", ("line twice", ""): line + line}
        for place in range(0, min(len(words) - 1, 2 * _WORDS_A_LINE), 2):
            for name, value in _WORDS.items():
                rest = words[place + 2 :] if value is None else [value, *words[place + 1 :]]
                changes[name, f".{place // 2 + 1}"] = "".join([*words[:place], *rest])
        for (name, where), changed_line in changes.items():
            content = "".join([*lines[:number], changed_line, *lines[number + 1 :]]).encode()
            yield Mutant(f"{number + 1}{where}", name, partial(bytes, content), "reject")
    others = {"Windows line ends": text.replace("\n", "\r\n"), "blank lines at the end": text + "\n\n"}
    for name, other in others.items():
        yield Mutant("document", name, partial(bytes, other.encode()), "either")


def mutated_bytes(content: bytes, name: str, body: Expectation = "either") -> Iterator[Mutant]:
    """Yield what can happen to the bytes of a file, and to the file as a whole."""
    half, header = len(content) // 2, min(32, len(content))
    changes: dict[str, tuple[bytes, Expectation]] = {
        "emptied": (b"", "reject"),
        "cut after the header": (content[:header], "reject"),
        "cut in half": (content[:half], "reject"),
        "last byte gone": (content[:-1], "either"),
        "zeroed": (bytes(len(content)), "reject"),
        "zeroed from the middle": (content[:half] + bytes(len(content) - half), body),
        "a bit of the header flipped": (_flipped(content, name, 0, header), "either"),
        "a bit of the body flipped": (_flipped(content, name, half // 2, len(content)), body),
        "text instead": (b"not what you think\n" * 20, "reject"),
        "doubled": (content + content, "either"),
    }
    for mutation, (changed, expect) in changes.items():
        if changed != content:
            yield Mutant("", mutation, partial(bytes, changed), expect)
    for mutation in _NO_FILES:
        yield Mutant("", mutation, partial(_no_file, mutation), "reject")


def _flipped(content: bytes, name: str, start: int, stop: int) -> bytes:
    if stop <= start:
        return content
    rng = stream("flip", name, start)
    place, bit = rng.randrange(start, stop), rng.randrange(8)
    return content[:place] + bytes([content[place] ^ (1 << bit)]) + content[place + 1 :]


_NO_FILES: dict[str, Callable[[Path], Any]] = {
    "missing": lambda path: None,
    "a folder in its place": Path.mkdir,
    "a dangling link": lambda path: path.symlink_to("nowhere"),
    "a link to a device": lambda path: path.symlink_to(os.devnull),
    "a link to a file elsewhere": lambda path: path.symlink_to("/etc/passwd"),
}


def _no_file(mutation: str) -> Callable[[Path], Any]:
    return _NO_FILES[mutation]


def at(data: Any, path: Place) -> Any:
    for key in path:
        data = data[key]
    return data


def _values(before: Any, path: Place, ending: str) -> dict[str, str]:
    number = before if isinstance(before, (int, float)) and not isinstance(before, bool) else None
    whole = isinstance(number, int)
    words = ("NaN", "Infinity", "-Infinity") if ending == ".json" else (".nan", ".inf", "-.inf")
    values = {
        **dict(zip(("nan", "inf", "minus_inf"), words, strict=True)),
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
    if _is_fraction(path):
        values["above_one"] = "1.5"
    return {name: token for name, token in values.items() if not _same(token, before)}


def _same(token: str, before: Any) -> bool:
    """Return whether a token means the value that is there already."""
    if isinstance(before, (int, float)) and not isinstance(before, bool):
        return bool(re.fullmatch(r"-?\d{1,40}(\.\d+)?(e\+\d+)?", token)) and float(token) == before
    return token == json.dumps(before)


def _dump(data: Any, ending: str) -> str:
    if ending == ".json":
        return json.dumps(data, indent=1)
    return yaml.safe_dump(data, sort_keys=False, width=10**6, allow_unicode=True)


def _with_token(data: Any, path: Place, token: str, ending: str) -> bytes:
    text = _dump(put_at(data, path, _MARK), ending)
    return text.replace(f'"{_MARK}"' if ending == ".json" else _MARK, token).encode()


def _with_key(data: Any, path: Place, change: str, ending: str) -> bytes:
    parent, key = deepcopy(at(data, path[:-1])), path[-1]
    if change == "deleted":
        del parent[key]
    elif change == "duplicated":
        parent[_MARK] = parent[key]
    else:
        wrong = str(key)[:-1] if len(str(key)) > 3 else f"{key}x"
        parent = {wrong if name == key else name: value for name, value in parent.items()}
    return _dump(put_at(data, path[:-1], parent), ending).replace(_MARK, str(key)).encode()


def put_at(data: Any, path: Place, value: Any) -> Any:
    """Return a copy of a document with another value at a place."""
    if not path:
        return value
    changed = deepcopy(data)
    at(changed, path[:-1])[path[-1]] = value
    return changed
