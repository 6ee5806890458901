"""The stored table of what is read of film says what the models say, and hangs together."""

import json

import pytest

from benchmarks.acceptance import film
from benchmarks.result import RESULTS

STORED = {row["name"]: row for row in json.loads((RESULTS / "film.json").read_text())["rows"]}


def test_readings_are_on_film_near_its_normal_and_behind_it_elsewhere() -> None:
    tables = [row["cells"] for row in STORED.values() if "cells" in row]
    assert len(tables) == 9
    for cells in tables:
        by_angle = {cell["angle_deg"]: cell for cell in cells}
        assert by_angle[0.0]["on_film"] > 0.1
        assert by_angle[0.0]["behind"] < by_angle[10.0]["behind"] < by_angle[40.0]["behind"]
        assert by_angle[40.0]["on_film"] < 0.01
        assert by_angle[40.0]["behind"] > 0.95
        for cell in cells:
            assert sum(cell[key] for key in ("on_film", "behind", "missing", "between")) == pytest.approx(1.0, abs=0.01)


def test_the_table_is_that_of_today() -> None:
    cell = next(cell for cell in STORED["d455 (depth camera)"]["cells"] if cell["angle_deg"] == 5.0)
    found = film._depth_fractions("d455", 5.0)
    assert found == pytest.approx((cell["on_film"], cell["behind"], cell["missing"]), abs=0.01)
