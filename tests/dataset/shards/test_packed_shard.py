"""Shards in archives, at a place that is no folder."""

import io
import tarfile
from contextlib import suppress
from pathlib import Path

import pytest

from warehouse_sim.dataset.shards.shard import pack_shard, packed_name, stored_shards, unpack_shard
from warehouse_sim.errors import DatasetError

fsspec = pytest.importorskip("fsspec")
PLACE = "memory://shards-of-a-test"


def make_folder(root: Path) -> Path:
    (root / "scenes").mkdir(parents=True)
    (root / "scenes/000000.json").write_bytes(b"{}")
    (root / "shard.json").write_bytes(b"1")
    return root


@pytest.mark.parametrize("local", [True, False])
def test_a_shard_comes_back_as_it_was(tmp_path: Path, local: bool) -> None:
    place = f"file://{tmp_path}/place" if local else PLACE
    assert stored_shards(place) == []
    pack_shard(make_folder(tmp_path / "shard"), place, packed_name(7))
    assert stored_shards(place) == ["shard-000007.tar"]
    (tmp_path / "back").mkdir()
    unpack_shard(place, packed_name(7), tmp_path / "back")
    names = sorted(str(path.relative_to(tmp_path / "back")) for path in (tmp_path / "back").rglob("*.*"))
    assert names == ["scenes/000000.json", "shard.json"]


def test_an_archive_that_could_not_be_written_to_its_end_is_not_there(tmp_path: Path, monkeypatch) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(tarfile.TarFile, "add", full)
    with pytest.raises(DatasetError, match=r"cannot be written .*No space left"):
        pack_shard(make_folder(tmp_path / "shard"), f"file://{tmp_path}/place", packed_name(0))
    assert stored_shards(f"file://{tmp_path}/place") == []


@pytest.mark.parametrize("name", ["../outside", "/tmp/outside-of-a-test"])
def test_nothing_leaves_the_folder(tmp_path: Path, name: str) -> None:
    with tarfile.open(tmp_path / packed_name(0), "w") as archive:
        member = tarfile.TarInfo(name)
        member.size = 1
        archive.addfile(member, io.BytesIO(b"x"))
    (tmp_path / "in").mkdir()
    with suppress(DatasetError):  # It is rejected, or kept inside.
        unpack_shard(f"file://{tmp_path}", packed_name(0), tmp_path / "in")
    assert not (tmp_path / "outside").exists()
    assert not Path("/tmp/outside-of-a-test").exists()


def test_a_damaged_archive_is_one_line(tmp_path: Path) -> None:
    (tmp_path / packed_name(0)).write_bytes(b"no archive")
    with pytest.raises(DatasetError, match=r"shard-000000\.tar: cannot be read .*; make the shard again"):
        unpack_shard(f"file://{tmp_path}", packed_name(0), tmp_path / "in")
