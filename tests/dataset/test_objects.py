import json
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from tests.dataset.toy import CARTON, PALLET
from warehouse_sim.dataset.formats.bop import bop_layout
from warehouse_sim.dataset.formats.bop.reader import read_model
from warehouse_sim.dataset.objects import read_objects, write_objects
from warehouse_sim.errors import DatasetError


def test_round_trip(tmp_path: Path) -> None:
    write_objects(tmp_path, [CARTON, PALLET])
    assert list(json.loads((tmp_path / "objects.json").read_text())) == ["1", "7"]
    objects = read_objects(tmp_path)
    assert list(objects) == [1, 7]
    for model in (PALLET, CARTON):
        info = objects[model.obj_id]
        assert (info.name, info.class_name, info.obj_id) == (model.name, model.class_name, model.obj_id)
        assert np.array_equal(info.size, model.size)
        assert np.array_equal(info.symmetry.transforms, model.symmetry.transforms)
        assert info.diameter == pytest.approx(np.linalg.norm(model.size), rel=1e-12)
    pocket, opposite = objects[1].pockets
    assert (pocket.face, opposite.face) == ("-y", "+y")
    assert np.array_equal(pocket.T_object_pocket, PALLET.pockets[0].T_object_pocket)
    assert np.array_equal(pocket.size, PALLET.pockets[0].size)
    assert objects[7].pockets == ()


def test_meshes_are_in_metres(toy_root: Path) -> None:
    info = read_objects(toy_root, partial(read_model, bop_layout(toy_root)))[1]
    mesh, metric = info.mesh(), info.metric_mesh()
    assert np.abs(mesh.vertices - PALLET.mesh().vertices).max() < 1e-7
    assert np.array_equal(mesh.faces, PALLET.mesh().faces)
    assert 2000 <= len(metric.vertices) <= 4000
    assert metric.face_areas().sum() == pytest.approx(PALLET.mesh().face_areas().sum(), rel=1e-6)


def test_missing_mesh_says_what_to_do(tmp_path: Path) -> None:
    write_objects(tmp_path, [PALLET])
    with pytest.raises(DatasetError, match="no mesh of toy-pallet; generate it in a format that holds meshes"):
        read_objects(tmp_path)[1].mesh()


def test_each_geometry_needs_its_own_number(tmp_path: Path) -> None:
    with pytest.raises(
        DatasetError, match="obj_id 1 of 'paired_variant' must be >= 1 and its own, 'toy-pallet' has it"
    ):
        write_objects(tmp_path, [PALLET, replace(PALLET, name="paired_variant")])
    with pytest.raises(DatasetError, match="obj_id 0 of 'toy-pallet' must be >= 1"):
        write_objects(tmp_path, [replace(PALLET, obj_id=0)])


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("size", [1.0, 2.0, 0.0], "size must be 3 numbers, each 0.0001 to 10000"),
        ("symmetries", [[[2, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]], "not a rigid 4x4 transform"),
        ("symmetries", [], "symmetries must hold the identity"),
        ("symmetries", [[[1, 0, 0, 1e9], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]], "must lead -1000000 to 1000000 m"),
        ("name", "../../x", "name must be a word of letters, digits and _ . ~ + -, found '../../x'"),
        ("diameter", 0, "diameter must be 0.0001-10,000 m, found 0.0"),
        ("diameter", 14.49, "diameter 14.49 m does not go with size [1.2, 0.8, 0.144] m"),
        ("diameter", 0.9, "two points of that box lie 1.2 to 1.44939 m apart at most"),
        (
            "pockets",
            [{"face": "+q", "size": [1, 1, 1], "T_object_pocket": np.eye(4).tolist()}],
            "face must be one of '-x', '+x'",
        ),
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


@pytest.mark.parametrize("content", ["{}", '{"0": {}}'])
def test_a_table_without_objects_is_rejected(tmp_path: Path, content: str) -> None:
    (tmp_path / "objects.json").write_text(content)
    with pytest.raises(DatasetError, match=r"objects\.json: must hold objects, numbered from 1"):
        read_objects(tmp_path)
