import os
from pathlib import Path

import pytest

from warehouse_sim.errors import OutputError
from warehouse_sim.output import hard_link, make_folder, remove_temporaries, write_bytes


@pytest.mark.parametrize("durable", [False, True])
def test_write_replaces_the_whole_file_and_leaves_nothing_else(tmp_path: Path, durable: bool) -> None:
    path = tmp_path / "a.bin"
    write_bytes(path, b"a much longer first content", durable)
    write_bytes(path, b"second", durable)
    assert path.read_bytes() == b"second"
    assert list(tmp_path.iterdir()) == [path]


def test_failed_write_keeps_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.bin"
    write_bytes(path, b"old")

    def full_disk(source: Path, target: Path) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full_disk)
    with pytest.raises(OutputError, match=r"a\.bin: cannot be written \(No space left on device\)"):
        write_bytes(path, b"new")
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_shared_file_is_stored_once(tmp_path: Path) -> None:
    first, second = tmp_path / "first", tmp_path / "second"
    write_bytes(first, b"content")
    write_bytes(second, b"of an earlier run")
    hard_link(first, second, b"content")
    assert second.samefile(first)
    assert second.read_bytes() == b"content"


def test_shared_file_is_copied_where_there_are_no_hard_links(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def no_links(source: Path, target: Path) -> None:
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr(os, "link", no_links)
    first, second = tmp_path / "first", tmp_path / "second"
    write_bytes(first, b"content")
    hard_link(first, second, b"content")
    assert second.read_bytes() == b"content"
    assert not second.samefile(first)


def test_leftovers_of_a_killed_run_are_removed(tmp_path: Path) -> None:
    (tmp_path / "deep").mkdir()
    leftover, kept = tmp_path / "deep" / ".000001.png.4711.part", tmp_path / "deep" / "000001.png"
    leftover.touch()
    kept.touch()
    remove_temporaries(tmp_path)
    assert kept.exists()
    assert not leftover.exists()


def test_a_name_with_a_zero_byte_is_rejected(tmp_path: Path) -> None:
    for write in (make_folder, lambda path: write_bytes(path, b"")):
        with pytest.raises(OutputError, match=r"a\\x00b.*zero byte"):
            write(tmp_path / "a\0b")
