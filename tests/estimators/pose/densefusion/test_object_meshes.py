from pathlib import Path

import numpy as np
import pytest
import safetensors.numpy

from tests.dataset.toy import PALLET
from tests.estimators.pose.densefusion.made_crops import pallet_shape
from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.pose.densefusion.object_meshes import MESHES, dataset_meshes, read_meshes, write_meshes


def test_meshes_come_back_as_they_were(toy_root: Path, tmp_path: Path) -> None:
    write_meshes(tmp_path, dataset_meshes([toy_root], [pallet_shape()]))
    (mesh,) = read_meshes(tmp_path).values()
    original = PALLET.mesh()
    corners, expected = mesh.vertices[mesh.faces], original.vertices[original.faces]
    np.testing.assert_allclose(corners, expected, atol=1e-6)
    assert mesh.face_areas().sum() == pytest.approx(original.face_areas().sum(), rel=1e-5)


def test_a_missing_or_broken_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(TrainingError, match="which ICP needs"):
        read_meshes(tmp_path)
    (tmp_path / MESHES).write_bytes(b"nothing of the kind")
    with pytest.raises(TrainingError, match="malformed"):
        read_meshes(tmp_path)


@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        ("faces", lambda faces: faces + 7, "a corner that is not there"),
        ("faces", lambda faces: faces - 1, "a corner that is not there"),
        ("faces", lambda faces: faces[:, :2], "no table of corners and one of faces"),
        ("faces", lambda faces: faces[:0], "no table of corners and one of faces"),
        ("vertices", lambda vertices: vertices * np.float32(np.nan), "no table of corners and one of faces"),
    ],
)
def test_numbers_that_are_no_surface_are_rejected(toy_root: Path, tmp_path: Path, name: str, change, words) -> None:
    write_meshes(tmp_path, dataset_meshes([toy_root], [pallet_shape()]))
    tensors = safetensors.numpy.load_file(tmp_path / MESHES)
    key = next(key for key in tensors if key.endswith(name))
    safetensors.numpy.save_file(tensors | {key: np.ascontiguousarray(change(tensors[key]))}, tmp_path / MESHES)
    with pytest.raises(TrainingError, match=words):
        read_meshes(tmp_path)
