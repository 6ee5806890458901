import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.dataset.toy import CARTON, PALLET
from warehouse_sim.dataset.objects import read_objects, write_objects
from warehouse_sim.errors import DatasetError


def test_round_trip(tmp_path: Path) -> None:
    write_objects(tmp_path, [CARTON, PALLET])
    objects = read_objects(tmp_path)
    assert list(objects) == [1, 7]
    for model in (PALLET, CARTON):
        info = objects[model.obj_id]
        assert (info.name, info.class_name, info.obj_id) == (model.name, model.class_name, model.obj_id)
        assert np.array_equal(info.size, model.size)
        assert np.array_equal(info.symmetry.transforms, model.symmetry.transforms)
        assert info.diameter == pytest.approx(np.linalg.norm(model.size), rel=1e-12)
    (pocket,) = objects[1].pockets
    assert pocket.face == "-y"
    assert np.array_equal(pocket.T_object_pocket, PALLET.pockets[0].T_object_pocket)
    assert np.array_equal(pocket.size, PALLET.pockets[0].size)
    assert objects[7].pockets == ()


def test_meshes_are_in_metres(toy_root: Path) -> None:
    info = read_objects(toy_root)[1]
    mesh, metric = info.mesh(), info.metric_mesh()
    assert np.abs(mesh.vertices - PALLET.mesh().vertices).max() < 1e-7
    assert np.array_equal(mesh.faces, PALLET.mesh().faces)
    assert 2000 <= len(metric.vertices) <= 4000
    assert metric.face_areas().sum() == pytest.approx(PALLET.mesh().face_areas().sum(), rel=1e-6)


def test_missing_mesh_says_what_to_do(tmp_path: Path) -> None:
    write_objects(tmp_path, [PALLET])
    with pytest.raises(DatasetError, match="no mesh of toy-pallet; generate the dataset with the format bop"):
        read_objects(tmp_path)[1].mesh()


def test_each_geometry_needs_its_own_number(tmp_path: Path) -> None:
    with pytest.raises(DatasetError, match="obj_id 1 of 'twin' must be >= 1 and its own, 'toy-pallet' has it"):
        write_objects(tmp_path, [PALLET, replace(PALLET, name="twin")])
    with pytest.raises(DatasetError, match="obj_id 0 of 'toy-pallet' must be >= 1"):
        write_objects(tmp_path, [replace(PALLET, obj_id=0)])


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("name", 3, "name must be of type str, found 3"),
        ("diameter", None, "diameter must be of type float"),
        ("size", [1.0, 2.0], "size must be three lengths above 0"),
        ("size", [1.0, 2.0, 0.0], "size must be three lengths above 0"),
        ("symmetries", [[[2, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]], "not a rigid 4x4 transform"),
        ("symmetries", [], "symmetries must hold at least the identity"),
        ("symmetries", [[1, 2, 3]], "not a rigid 4x4 transform"),
        ("pockets", [{"face": "-x", "size": [1, 1, 1]}], "pockets[0]: the entry 'T_object_pocket' is missing"),
    ],
)
def test_malformed_entries_are_named(tmp_path: Path, key: str, value: object, message: str) -> None:
    write_objects(tmp_path, [PALLET])
    data = json.loads((tmp_path / "objects.json").read_text())
    data["1"][key] = value
    (tmp_path / "objects.json").write_text(json.dumps(data))
    with pytest.raises(DatasetError) as caught:
        read_objects(tmp_path)
    assert message in str(caught.value)
    assert "objects.json: 1" in str(caught.value)
