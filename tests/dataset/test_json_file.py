import json
import math
from pathlib import Path

import pytest

from warehouse_sim.dataset.json_file import read_json, write_json
from warehouse_sim.errors import DatasetError


@pytest.mark.parametrize("depth", [0, 1, 2, 5])
def test_round_trip_keeps_every_digit(tmp_path: Path, depth: int) -> None:
    data = {"a": [1.0 / 3.0, math.pi * 1e-7, 2**53 - 1.0], "b": {"c": [], "d": {}}, "e": [[1, 2], ["x", None, True]]}
    write_json(tmp_path / "a.json", data, depth)
    assert read_json(tmp_path / "a.json") == data


def test_one_entry_a_line(tmp_path: Path) -> None:
    write_json(tmp_path / "a.json", {"0": [1, 2], "1": [3]})
    assert (tmp_path / "a.json").read_text() == '{\n  "0": [1, 2],\n  "1": [3]\n}\n'


@pytest.mark.parametrize("value", [math.nan, math.inf, object()])
def test_what_json_cannot_hold_is_refused(tmp_path: Path, value: object) -> None:
    with pytest.raises(DatasetError, match=r"a\.json: cannot be written as JSON"):
        write_json(tmp_path / "a.json", {"x": [value]})
    assert not (tmp_path / "a.json").exists()


def test_unreadable_files_are_named(tmp_path: Path) -> None:
    (tmp_path / "half.json").write_text(json.dumps({"a": 1})[:-1])
    with pytest.raises(DatasetError, match=r"half\.json: is not valid JSON"):
        read_json(tmp_path / "half.json")
    with pytest.raises(DatasetError, match=r"none\.json: cannot be read \(No such file"):
        read_json(tmp_path / "none.json")
