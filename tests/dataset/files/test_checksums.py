"""Checksums beside the meshes, refereed by coreutils."""

import shutil
import subprocess
from pathlib import Path

import pytest

from warehouse_sim.dataset.files.checksums import require_checksum
from warehouse_sim.errors import DatasetError


@pytest.mark.parametrize("kind", ["models", "models_eval"])
def test_sha256sum_agrees(toy_root: Path, kind: str) -> None:
    folder = toy_root / "bop" / kind
    done = subprocess.run(
        ["sha256sum", "--check", "--strict", "SHA256SUMS"], cwd=folder, capture_output=True, text=True
    )
    assert (done.returncode, done.stdout) == (0, "obj_000001.ply: OK\n")


def test_another_byte_or_name_is_rejected(toy_copy: Path) -> None:
    path = toy_copy / "bop/models/obj_000001.ply"
    require_checksum(path)
    other = path.with_name("obj_000002.ply")
    shutil.copy(path, other)
    path.write_bytes(path.read_bytes()[:-1] + b"\7")
    for changed in (path, other):
        with pytest.raises(DatasetError, match=f"{changed.name}: is not the file that SHA256SUMS lists"):
            require_checksum(changed)


def test_an_empty_list_lists_nothing(toy_copy: Path) -> None:
    path = toy_copy / "bop/models/obj_000001.ply"
    path.with_name("SHA256SUMS").write_bytes(b"")
    with pytest.raises(DatasetError, match="is not the file that SHA256SUMS lists"):
        require_checksum(path)


def test_a_dataset_without_checksums_says_nothing(toy_copy: Path) -> None:
    path = toy_copy / "bop/models/obj_000001.ply"
    (path.parent / "SHA256SUMS").unlink()
    path.write_bytes(b"")
    require_checksum(path)
