"""Rows that are measured again beside those that are stored."""

import json
from pathlib import Path

from benchmarks.speed.result import beside_stored


def test_other_rows_stay_and_keep_their_places(tmp_path: Path) -> None:
    file = tmp_path / "result.json"
    first = [{"name": "a", "value": 1}, {"name": "b", "value": 2}]
    assert beside_stored(file, first) == first
    file.write_text(json.dumps({"rows": first}))
    assert beside_stored(file, [{"name": "c", "value": 4}, {"name": "a", "value": 3}]) == [
        {"name": "a", "value": 3},
        {"name": "b", "value": 2},
        {"name": "c", "value": 4},
    ]
