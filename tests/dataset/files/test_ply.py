from pathlib import Path

import numpy as np
import pytest

from tests.dataset.toy import PALLET
from warehouse_sim.dataset.files.ply import read_ply, write_ply
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.mesh import TriangleMesh


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
def test_other_layouts_are_rejected(tmp_path: Path, change) -> None:
    path = tmp_path / "a.ply"
    write_ply(path, PALLET.mesh())
    path.write_bytes(change(path.read_bytes()))
    with pytest.raises(DatasetError, match=r"a\.ply: is not a mesh written by this package"):
        read_ply(path)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e30])
def test_a_vertex_is_finite(tmp_path: Path, value: float) -> None:
    mesh = PALLET.mesh()
    vertices = mesh.vertices.copy()
    vertices[5, 1] = value
    write_ply(tmp_path / "a.ply", TriangleMesh(vertices, mesh.faces))
    with pytest.raises(DatasetError, match=r"a\.ply: a vertex is not finite, or 1e\+07 mm away"):
        read_ply(tmp_path / "a.ply")


@pytest.mark.parametrize("index", [-1, 24, 2**31 - 1])
def test_a_face_has_corners_that_exist(tmp_path: Path, index: int) -> None:
    mesh = PALLET.mesh()
    faces = mesh.faces.copy()
    faces[3, 2] = index
    write_ply(tmp_path / "a.ply", TriangleMesh(mesh.vertices, faces))
    with pytest.raises(DatasetError, match="a face is no triangle of its 24 vertices"):
        read_ply(tmp_path / "a.ply")


def test_a_header_of_endless_digits_is_rejected(tmp_path: Path) -> None:
    write_ply(tmp_path / "a.ply", PALLET.mesh())
    content = (tmp_path / "a.ply").read_bytes().replace(b"vertex 24", b"vertex " + b"9" * 5001)
    (tmp_path / "a.ply").write_bytes(content)
    with pytest.raises(DatasetError, match="is not a mesh written by this package"):
        read_ply(tmp_path / "a.ply")


def test_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(DatasetError, match=r"none\.ply: cannot be read"):
        read_ply(tmp_path / "none.ply")
