"""Shards in a bucket of a server that speaks S3 on loopback: a reader sees whole archives or none."""

import os
import signal
import subprocess
import sys
import tarfile
import time
import zlib
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.dataset.shards.test_merge import make_shard
from tests.dataset.toy import make_dataset
from tests.shared import hashes
from warehouse_sim.dataset.shards.shard import pack_shard, packed_name, stored_shards, unpack_shard
from warehouse_sim.errors import DatasetError
from warehouse_sim.generation.ray_cluster import merge_packed

pytestmark = pytest.mark.s3
fsspec = pytest.importorskip("fsspec")
pytest.importorskip("s3fs")
moto = pytest.importorskip("moto.server")
SLOW_UPLOAD = """
import sys, tarfile, time
from pathlib import Path
from warehouse_sim.dataset.shards import shard
add = tarfile.TarFile.add
def slow(self, path, *more, **named):
    add(self, path, *more, **named)
    print("sent", flush=True)
    time.sleep(60)
tarfile.TarFile.add = slow
shard.pack_shard(Path(sys.argv[1]), sys.argv[2], shard.packed_name(0))
"""


@pytest.fixture
def bucket(monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest) -> Iterator[str]:
    """Return a place in a bucket of the test's own; what servers of one process hold is shared."""
    name = f"shards-{zlib.crc32(request.node.name.encode())}"
    server = moto.ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    server.start()
    host, port = server.get_host_and_port()
    for key, value in {
        "AWS_ENDPOINT_URL": f"http://{host}:{port}",
        "AWS_ACCESS_KEY_ID": "nobody",
        "AWS_SECRET_ACCESS_KEY": "nothing",
        "AWS_DEFAULT_REGION": "us-east-1",
    }.items():
        monkeypatch.setenv(key, value)
    fsspec.filesystem("s3", skip_instance_cache=True).mkdir(name)
    fsspec.get_filesystem_class("s3").clear_instance_cache()
    yield f"s3://{name}/data"
    fsspec.get_filesystem_class("s3").clear_instance_cache()
    server.stop()


def in_another_process(code: str, *words: str) -> None:
    subprocess.run([sys.executable, "-c", code, *words], check=True, env=surroundings(), timeout=300)


def surroundings() -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}


PACK = """
import sys
from pathlib import Path
from warehouse_sim.dataset.shards.shard import pack_shard, packed_name
pack_shard(Path(sys.argv[1]), sys.argv[2], packed_name(1))
"""


def test_shards_that_this_and_another_process_stored_become_the_dataset_of_one_run(bucket: str, tmp_path: Path) -> None:
    assert stored_shards(bucket) == []
    pack_shard(make_shard(tmp_path / "0", 0, 2), bucket, packed_name(0))
    assert stored_shards(bucket) == [packed_name(0)]
    in_another_process(PACK, str(make_shard(tmp_path / "1", 1, 2)), bucket)
    # What was listed before must not be what is listed now.
    assert stored_shards(bucket) == [packed_name(0), packed_name(1)]
    merge_packed(bucket, tmp_path / "merged")
    assert hashes(tmp_path / "merged") == hashes(make_dataset(tmp_path / "one"))


def test_a_large_archive_comes_back_as_it_was(bucket: str, tmp_path: Path) -> None:
    (tmp_path / "shard").mkdir()
    (tmp_path / "shard" / "large.bin").write_bytes(os.urandom(12 << 20))  # more parts than one
    pack_shard(tmp_path / "shard", bucket, packed_name(3))
    (tmp_path / "back").mkdir()
    unpack_shard(bucket, packed_name(3), tmp_path / "back")
    assert hashes(tmp_path / "back") == hashes(tmp_path / "shard")


def test_an_upload_that_fails_leaves_nothing(bucket: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    added = tarfile.TarFile.add

    def fails_at_the_second(self: tarfile.TarFile, path: Path, *more: object, **named: object) -> None:
        if self.getmembers():
            raise OSError(5, "Input/output error")
        added(self, path, *more, **named)  # type: ignore[arg-type]

    (tmp_path / "shard").mkdir()
    for name in ("a", "b"):
        (tmp_path / "shard" / name).write_bytes(bytes(6 << 20))
    monkeypatch.setattr(tarfile.TarFile, "add", fails_at_the_second)
    with pytest.raises(DatasetError, match=r"shard-000000\.tar: cannot be written .*Input/output error"):
        pack_shard(tmp_path / "shard", bucket, packed_name(0))
    assert stored_shards(bucket) == []
    monkeypatch.undo()


def test_an_upload_that_is_killed_leaves_nothing(bucket: str, tmp_path: Path) -> None:
    (tmp_path / "shard").mkdir()
    for name in ("a", "b"):
        (tmp_path / "shard" / name).write_bytes(bytes(6 << 20))
    words = [sys.executable, "-c", SLOW_UPLOAD, str(tmp_path / "shard"), bucket]
    with subprocess.Popen(words, stdout=subprocess.PIPE, env=surroundings()) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"sent\n"
        time.sleep(0.5)
        process.send_signal(signal.SIGKILL)
    assert stored_shards(bucket) == []
    pack_shard(tmp_path / "shard", bucket, packed_name(0))
    assert stored_shards(bucket) == [packed_name(0)]


def test_places_that_are_not_there_are_one_line(bucket: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(DatasetError, match=r"shard-000009\.tar: cannot be read"):
        unpack_shard(bucket, packed_name(9), tmp_path)
    monkeypatch.setenv("AWS_ENDPOINT_URL", "http://127.0.0.1:9")  # nobody listens
    monkeypatch.setenv("AWS_MAX_ATTEMPTS", "1")  # it answers no later try either
    monkeypatch.setattr(fsspec.get_filesystem_class("s3"), "retries", 1)
    fsspec.get_filesystem_class("s3").clear_instance_cache()
    with pytest.raises(DatasetError, match="cannot be read"):
        stored_shards(bucket)
