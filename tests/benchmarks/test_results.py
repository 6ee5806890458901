"""Committed results have one shape: machine, command, named rows of numbers."""

import json
from pathlib import Path

import pytest

RESULTS = sorted((Path(__file__).resolve().parents[2] / "benchmarks" / "results").glob("*.json"))


def test_there_are_results() -> None:
    assert RESULTS


@pytest.mark.parametrize("path", RESULTS, ids=lambda path: path.stem)
def test_a_result_says_how_it_was_measured(path: Path) -> None:
    result = json.loads(path.read_text())
    assert result["machine"]
    assert result["command"]
    names = [row["name"] for row in result["rows"]]
    assert len(names) == len(set(names)) > 0
    for row in result["rows"]:
        numbers = [value for key, value in row.items() if key in ("value", "ours_cpu_s")]
        assert numbers
        assert all(value >= 0 for value in numbers)
        if "interval" in row:
            low, high = row["interval"]
            assert low <= row["value"] <= high
