"""YAML from anyone: every rejection is one line that names file and line, and nothing hangs or grows without bound."""

import time
from pathlib import Path

import pytest

from warehouse_sim.errors import ConfigError
from warehouse_sim.yaml_file import read_yaml

LAUGHS = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]\n" for i in range(1, 12)
)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: 1\nb: 2\na: 3\n", "line 3: 'a' was given in line 1; keep one"),
        ("a: {b: [{c: 1, c: 2}]}\n", "line 1: 'c' was given in line 1; keep one"),
        ('a: 1\n"a": 2\n', "line 2: 'a' was given in line 1"),
        ("a: " + "[" * 3000 + "]" * 3000, "line 1: nested more than 32 deep"),
        ("".join(f"{' ' * i}k:\n" for i in range(100)), "line 32: nested more than 32 deep"),
        ("\na: " + "9" * 5001, "line 2: an integer of 5001 digits is no setting"),
        ("a: 0x" + "f" * 5001, "line 1: an integer of 5003 digits is no setting"),
        (LAUGHS, "more than 100000 values"),
        ("a: &a [*a]\n", "line 1: an alias within what it stands for has no end"),
        ("a: 2026-99-99\n", "is not valid YAML"),
        ("a: !!python/object/apply:os.system [ls]\n", "is not valid YAML"),
        ("x" * 1_000_001, "is larger than 1000 kB"),
        ("[1]: [unclosed", "is not valid YAML"),
        ("{a: 1}: 2", "is not valid YAML"),
        ("\0", "is not valid YAML"),
    ],
)
def test_what_is_no_settings_file_is_rejected_in_one_line(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "own.yaml"
    path.write_text(text)
    start = time.monotonic()
    with pytest.raises(ConfigError) as caught:
        read_yaml(path)
    assert time.monotonic() - start < 5.0
    assert message in str(caught.value)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)


def test_what_cannot_be_opened_is_rejected(tmp_path: Path) -> None:
    (tmp_path / "bytes.yaml").write_bytes(b"\xff\xfe\xff")
    for path in (tmp_path / "none.yaml", tmp_path, Path("/dev/zero"), tmp_path / ("x" * 5000), tmp_path / "bytes.yaml"):
        with pytest.raises(ConfigError):
            read_yaml(path)


def test_aliases_merges_and_marks_are_read(tmp_path: Path) -> None:
    path = tmp_path / "own.yaml"
    path.write_bytes(b"\xef\xbb\xbfbase: &base {a: 1, b: 2}\nown: {<<: *base, b: 3}\nlist: [*base, *base]\n")
    assert read_yaml(path) == {
        "base": {"a": 1, "b": 2},
        "own": {"a": 1, "b": 3},
        "list": [{"a": 1, "b": 2}, {"a": 1, "b": 2}],
    }
