import json
import math
from pathlib import Path

import pytest

from warehouse_sim.dataset.files.json_file import read_json, read_table, write_json
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
def test_what_json_cannot_hold_is_rejected(tmp_path: Path, value: object) -> None:
    with pytest.raises(DatasetError, match=r"a\.json: cannot be written as JSON"):
        write_json(tmp_path / "a.json", {"x": [value]})
    assert not (tmp_path / "a.json").exists()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("[" * 100_000, "nests more than 64 levels deep"),
        ('{"a":' * 3000 + "1" + "}" * 3000, "nests more than 64 levels deep"),
        ("[" * 65 + "]" * 65, "nests more than 64 levels deep"),
        ("9" * 5001, "is too large"),
        ("9223372036854775808", "9223372036854775808 is too large"),
        ("[1e999]", "1e999 is too large"),
        ("[0.5, -1E+0999]", "-1E+0999 is too large"),
        ("[" + "1" * 310 + ".5]", "is too large"),
        ("[-9223372036854775809]", "-9223372036854775809 is too large"),
        ("[NaN]", "NaN is no JSON number"),
        ("[-Infinity]", "-Infinity is no JSON number"),
        ('{"a": 1, "a": 2}', "the key 'a' comes twice"),
    ],
)
def test_what_no_file_of_a_dataset_holds_is_rejected(tmp_path: Path, content: str, message: str) -> None:
    (tmp_path / "a.json").write_text(content)
    with pytest.raises(DatasetError) as caught:
        read_json(tmp_path / "a.json")
    assert message in str(caught.value)
    assert len(str(caught.value)) < 300


def test_what_is_still_allowed_is_read(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text("[" * 64 + "9223372036854775807, -1e308" + "]" * 64)
    inner = read_json(tmp_path / "a.json")
    for _ in range(63):
        (inner,) = inner
    assert inner == [2**63 - 1, -1e308]


@pytest.mark.parametrize("key", ["007", "-1", "1.0", "one", "\u0663", "1" * 10])
def test_keys_of_a_table_are_plain_numbers(tmp_path: Path, key: str) -> None:
    (tmp_path / "a.json").write_text(json.dumps({key: 1}))
    with pytest.raises(DatasetError, match="expected a table whose keys are numbers"):
        read_table(tmp_path / "a.json")


def test_unreadable_files_are_named(tmp_path: Path) -> None:
    (tmp_path / "half.json").write_text(json.dumps({"a": 1})[:-1])
    with pytest.raises(DatasetError, match=r"half\.json: is not valid JSON"):
        read_json(tmp_path / "half.json")
    with pytest.raises(DatasetError, match=r"none\.json: cannot be read \(No such file"):
        read_json(tmp_path / "none.json")
