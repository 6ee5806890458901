"""JSON as this package writes and reads it: full float64 digits, no NaN, one line an entry, atomic and durable.

What comes from a file is bounded before anyone uses it: numbers fit into 64 bits, keys come once, and nesting ends
where no dataset file has any. Files of this package nest ten levels deep at most.
"""

import json
import math
import re
from pathlib import Path
from typing import Any

from warehouse_sim.dataset.files.extent import ADVICE, Source, read_bytes, where_of
from warehouse_sim.errors import DatasetError
from warehouse_sim.output import write_bytes

_DEEPEST = 64
_LARGEST_WHOLE = 2**63 - 1
_TABLE_KEY = re.compile("0|[1-9][0-9]{0,8}")
_FAR = re.compile("[eE][+]?[0-9]{3}|[0-9]{19}")
"""What a number beyond 64 bits has at least: an exponent of three digits, or nineteen digits in a row."""


def write_json(path: Path, data: Any, depth: int = 1) -> None:
    """Write ``data`` so that containers are spread over lines down to ``depth`` and compact below.

    Raises:
        DatasetError: The data hold what JSON cannot (NaN, infinity, objects).
        OutputError: The file cannot be written.
    """
    try:
        text = _spread(data, depth, "") + "\n"
    except (TypeError, ValueError) as problem:
        raise DatasetError(f"{path}: cannot be written as JSON ({problem})") from problem
    write_bytes(path, text.encode("utf-8"), durable=True)


def read_json(source: Source) -> Any:
    """Read a JSON file in UTF-8, or a part of a file.

    Raises:
        DatasetError: The file is missing, is not JSON, nests too deeply, or holds a number beyond 64 bits.
    """
    where = where_of(source)
    try:
        text = read_bytes(source).decode("utf-8")
    except UnicodeDecodeError as problem:
        raise DatasetError(f"{where}: is not valid JSON ({problem}); {ADVICE}") from problem
    # To look at each number takes longer than all the rest: only where one may be too large.
    checks: dict[str, Any] = {"parse_float": _float, "parse_int": _whole} if _FAR.search(text) else {}
    try:
        data = json.loads(text, parse_constant=_reject, object_pairs_hook=_mapping, **checks)
    except ValueError as problem:
        raise DatasetError(f"{where}: is not valid JSON ({problem}); {ADVICE}") from problem
    except RecursionError as problem:
        raise DatasetError(f"{where}: nests more than {_DEEPEST} levels deep; {ADVICE}") from problem
    if not _ends_within(data, _DEEPEST):
        raise DatasetError(f"{where}: nests more than {_DEEPEST} levels deep; {ADVICE}")
    return data


def read_table(path: Path) -> dict[int, Any]:
    """Read a JSON object whose keys are whole numbers below 1e9, in order of the numbers.

    Raises:
        DatasetError: The file is missing, is not JSON, or is no such table.
    """
    data = read_json(path)
    if not isinstance(data, dict) or not all(_TABLE_KEY.fullmatch(key) for key in data):
        raise DatasetError(f"{path}: expected a table whose keys are numbers")
    return {number: data[str(number)] for number in sorted(int(key) for key in data)}


def _reject(constant: str) -> None:
    raise ValueError(f"{constant} is no JSON number")


def _float(text: str) -> float:
    number = float(text)
    if not math.isfinite(number):
        raise ValueError(f"{text[:30]} is too large")
    return number


def _whole(text: str) -> int:
    if len(text) > 20 or abs(int(text)) > _LARGEST_WHOLE:
        raise ValueError(f"{text[:30]} is too large")
    return int(text)


def _mapping(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    data = dict(pairs)
    if len(data) < len(pairs):
        keys = [key for key, _ in pairs]
        twice = next(key for key in keys if keys.count(key) > 1)
        raise ValueError(f"the key {twice[:30]!r} comes twice")
    return data


def _ends_within(data: Any, levels: int) -> bool:
    """Return whether containers nest at most ``levels`` deep; level by level, not by recursion."""
    containers = [data] if isinstance(data, (dict, list)) else []
    for _ in range(levels):
        items = (item for box in containers for item in (box.values() if isinstance(box, dict) else box))
        containers = [item for item in items if isinstance(item, (dict, list))]
        if not containers:
            return True
    return False


def _spread(data: Any, depth: int, indent: str) -> str:
    if depth == 0 or not isinstance(data, (dict, list, tuple)) or not data:
        return json.dumps(data, allow_nan=False)
    inner = indent + "  "
    if isinstance(data, dict):
        items = [f"{json.dumps(str(key))}: {_spread(value, depth - 1, inner)}" for key, value in data.items()]
        left, right = "{", "}"
    else:
        items = [_spread(value, depth - 1, inner) for value in data]
        left, right = "[", "]"
    return f"{left}\n{inner}" + f",\n{inner}".join(items) + f"\n{indent}{right}"
