from pathlib import Path

import numpy as np
import pytest

from tests.dataset.toy import PALLET
from warehouse_sim.dataset.ply import read_ply, write_ply
from warehouse_sim.errors import DatasetError


def test_round_trip_in_float32(tmp_path: Path) -> None:
    mesh = PALLET.mesh()
    write_ply(tmp_path / "a.ply", mesh)
    read = read_ply(tmp_path / "a.ply")
    assert np.array_equal(read.vertices, mesh.vertices.astype(np.float32))
    assert np.array_equal(read.faces, mesh.faces)


@pytest.mark.parametrize(
    "change",
    [
        lambda content: b"",
        lambda content: content[:-1],
        lambda content: content + b"\0",
        lambda content: content.replace(b"property float z", b"property double z"),
        lambda content: content.replace(b"vertex 24", b"vertex 25"),
        lambda content: content.replace(b"binary_little_endian", b"ascii"),
    ],
)
def test_other_layouts_are_refused(tmp_path: Path, change) -> None:
    path = tmp_path / "a.ply"
    write_ply(path, PALLET.mesh())
    path.write_bytes(change(path.read_bytes()))
    with pytest.raises(DatasetError, match=r"a\.ply: is not a mesh written by this package"):
        read_ply(path)


def test_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(DatasetError, match=r"none\.ply: cannot be read"):
        read_ply(tmp_path / "none.ply")
