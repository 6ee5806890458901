"""JSON as this package writes and reads it: full float64 digits, no NaN, one line an entry, atomic and durable."""

import json
from pathlib import Path
from typing import Any

from warehouse_sim.errors import DatasetError
from warehouse_sim.output import write_bytes


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


def read_json(path: Path) -> Any:
    """Read a JSON file.

    Raises:
        DatasetError: The file is missing or is not JSON.
    """
    try:
        return json.loads(path.read_text(encoding="utf-8"), parse_constant=_refuse)
    except OSError as problem:
        raise DatasetError(
            f"{path}: cannot be read ({problem.strerror}); run 'warehouse-sim validate' on the dataset"
        ) from problem
    except ValueError as problem:
        raise DatasetError(
            f"{path}: is not valid JSON ({problem}); run 'warehouse-sim validate' on the dataset"
        ) from problem


def read_table(path: Path) -> dict[int, Any]:
    """Read a JSON object whose keys are whole numbers, in order of the numbers.

    Raises:
        DatasetError: The file is missing, is not JSON, or is no such table.
    """
    data = read_json(path)
    if not isinstance(data, dict) or not all(key.isdecimal() for key in data):
        raise DatasetError(f"{path}: expected a table whose keys are numbers")
    return {number: data[str(number)] for number in sorted(int(key) for key in data)}


def _refuse(constant: str) -> None:
    raise ValueError(f"{constant} is no JSON number")


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
