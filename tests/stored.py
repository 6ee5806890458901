"""Results that slow tests hold: measured again and compared, or stored again with ``STORE_RESULTS=1``."""

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from benchmarks.speed.result import RESULTS, beside_stored, rounded, write_result

ROOT = Path(__file__).resolve().parents[1]


def held(name: str, test: str, measured: Sequence[dict[str, Any]], **more: Any) -> dict[str, dict[str, Any]]:
    """Return the rows of a stored result by their names.

    With ``STORE_RESULTS=1`` in the environment, the measured rows take their places in it first.

    Args:
        name: Of the file in benchmarks/results, without its ending.
        test: Path of the test that measures.
        measured: Rows with a ``name`` and a ``value``.
        more: What else is to be known of the measurement, such as its data.
    """
    path = RESULTS / f"{name}.json"
    if os.environ.get("STORE_RESULTS"):
        command = f"STORE_RESULTS=1 python -m pytest {Path(test).relative_to(ROOT)}"
        write_result(path, command, beside_stored(path, rounded(list(measured))), **more)
    return {row["name"]: row for row in json.loads(path.read_text(encoding="utf-8"))["rows"]}
