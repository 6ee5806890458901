from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import safetensors.numpy
import torch

from tests.dataset.toy import PALLET
from tests.estimators.pose.densefusion.made_crops import DIAMETER, MESH, pallet_shape
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import ConfigError, TrainingError
from warehouse_sim.estimators.pose.densefusion.objects import (
    MESHES,
    dataset_meshes,
    measure_shape,
    read_meshes,
    shape_tensors,
    write_meshes,
)
from warehouse_sim.geometry.mesh import sample_surface
from warehouse_sim.geometry.symmetry import SymmetryGroup


def test_anchors_have_mean_and_covariance_of_the_surface() -> None:
    points, _ = sample_surface(MESH, 100_000, np.random.default_rng(1))
    anchors = shape_tensors([pallet_shape()]).anchors[0].double().numpy() * DIAMETER / 2
    np.testing.assert_allclose(anchors.mean(axis=0), points.mean(axis=0), atol=1e-6)
    np.testing.assert_allclose(np.cov(anchors.T, bias=True), np.cov(points.T, bias=True), atol=1e-6)


def test_shape_is_measured_from_the_dataset(toy_root) -> None:
    info: ObjectInfo = DatasetReader(toy_root).objects[1]
    shape = measure_shape(info, np.random.default_rng(0))
    assert (shape.obj_id, shape.name) == (1, "toy-pallet")
    assert abs(shape.diameter - DIAMETER) < 1e-3
    np.testing.assert_allclose(np.reshape(shape.symmetries, (-1, 4, 4)), PALLET.symmetry.transforms, atol=1e-9)
    np.testing.assert_allclose(shape.centroid, pallet_shape().centroid, atol=0.01)


def test_without_colour_what_has_the_same_shape_looks_the_same(toy_root) -> None:
    printed = replace(DatasetReader(toy_root).objects[1], symmetry=SymmetryGroup.trivial())
    seen, felt = (measure_shape(printed, np.random.default_rng(0), sees) for sees in (True, False))
    assert len(seen.symmetries) == 1
    np.testing.assert_array_equal(np.reshape(felt.symmetries, (-1, 4, 4)), SymmetryGroup.turns("z", 2).transforms)


def test_surface_points_are_kept_on_request(toy_root) -> None:
    info: ObjectInfo = DatasetReader(toy_root).objects[1]
    assert measure_shape(info, np.random.default_rng(0)).surface == ()
    shape = measure_shape(info, np.random.default_rng(0), surface_points=500)
    surface = shape_tensors([shape]).surface
    assert surface.shape == (1, 500, 3)
    points = surface[0].double().numpy() * shape.diameter / 2
    np.testing.assert_allclose(points.mean(axis=0), shape.centroid, atol=0.05)
    vertices = info.mesh().vertices
    assert (points > vertices.min(axis=0) - 1e-4).all()
    assert (points < vertices.max(axis=0) + 1e-4).all()


def test_groups_are_padded_with_the_identity() -> None:
    shape = pallet_shape()
    alone = type(shape)(**{**shape.__dict__, "obj_id": 2, "symmetries": shape.symmetries[:1]})
    tensors = shape_tensors([shape, alone])
    assert tensors.symmetry_rotation.shape == (2, 2, 3, 3)
    assert torch.equal(tensors.symmetry_rotation[1], torch.eye(3).expand(2, 3, 3))
    assert torch.equal(tensors.symmetry_rotation[0, 1], torch.diag(torch.tensor([-1.0, -1.0, 1.0])))


MIRROR = tuple(np.diag([-1.0, 1.0, 1.0, 1.0]).ravel().tolist())


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"symmetries": ()}, "16 numbers"),
        ({"symmetries": (tuple(np.eye(4).ravel().tolist()[:15]),)}, "16 numbers"),
        ({"symmetries": (MIRROR,)}, "the identity first"),
        ({"symmetries": (*pallet_shape().symmetries, MIRROR)}, "must be poses"),
        ({"covariance": (1.0,) * 8}, "covariance 9"),
        ({"centroid": (0.0, 0.0)}, "centroid must be 3"),
        ({"surface": (0.0,) * 4}, "surface 3 a point"),
    ],
)
def test_a_shape_that_is_none_is_rejected(change: dict, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        replace(pallet_shape(), **change)


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
