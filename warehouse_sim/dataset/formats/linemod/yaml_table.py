"""The YAML tables of LINEMOD: numbers by frame or object; written line by line, read within bounds."""

import json
import re
from pathlib import Path
from typing import Any

import yaml

from warehouse_sim.errors import DatasetError

_MOST_BYTES = 2**26
_EXPONENT = re.compile(r"(?<![\d.])(-?\d+)e")


def yaml_row(data: Any) -> str:
    """Return plain data in one line of YAML.

    YAML 1.1 takes 1e-05 for a word: numbers with an exponent get a point.
    """
    return _EXPONENT.sub(r"\1.0e", json.dumps(data, allow_nan=False))


def read_yaml_table(path: Path) -> dict[int, Any]:
    """Read a table whose keys are whole numbers, in their order.

    Raises:
        DatasetError: The file is missing, too large, is not YAML or is no such table, or refers to parts of itself.
    """
    try:
        if path.stat().st_size > _MOST_BYTES:
            raise DatasetError(f"{path}: is larger than {_MOST_BYTES} bytes; that is no table of LINEMOD")
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as problem:
        raise DatasetError(f"{path}: cannot be read ({problem}); the dataset is incomplete") from problem
    if "&" in text or "*" in text:
        raise DatasetError(f"{path}: holds an anchor or an alias of YAML; tables of LINEMOD have numbers only")
    try:
        # libyaml, where it was built in, reads a table of a thousand frames in a fifth of the time.
        data = yaml.load(text, getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    except (yaml.YAMLError, ValueError, RecursionError) as problem:
        raise DatasetError(f"{path}: is not valid YAML ({' '.join(str(problem).split())[:200]})") from problem
    if not isinstance(data, dict) or not all(type(key) is int and 0 <= key < 10**9 for key in data):
        raise DatasetError(f"{path}: expected a table whose keys are numbers")
    return {key: data[key] for key in sorted(data)}
