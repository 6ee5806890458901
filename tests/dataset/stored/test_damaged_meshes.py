"""Damaged targets have their own surface in the dataset."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

from tests.dataset.toy import MODELS, PALLET, make_dataset, make_scene
from warehouse_sim.dataset.files.ply import write_ply
from warehouse_sim.dataset.stored.scene_record import read_damaged_mesh, read_scene_record
from warehouse_sim.dataset.validate import validate
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.schema import SceneSpec

DAMAGED = replace(PALLET, name=f"{PALLET.name}~0badcafe", parts=PALLET.parts[:-1])
"""A pallet that has lost a board."""


def damaged_scene(index: int) -> SceneSpec:
    scene = make_scene(index)
    instances = tuple(replace(item, model=DAMAGED.name) if item.instance_id == 11 else item for item in scene.instances)
    return replace(scene, models={**MODELS, DAMAGED.name: DAMAGED}, instances=instances)


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_dataset(tmp_path_factory.mktemp("damaged") / "data", scene_of=damaged_scene)


def test_another_reader_finds_the_surface_without_the_lost_board(root: Path) -> None:
    mesh = trimesh.load(root / "damaged" / f"{DAMAGED.name}.ply", process=False)
    np.testing.assert_allclose(mesh.vertices / 1000.0, DAMAGED.mesh().vertices, atol=1e-6)
    assert len(mesh.faces) == len(PALLET.mesh().faces) - len(PALLET.parts[-1].mesh.faces)


def test_the_reader_gives_it_back_for_damaged_objects_only(root: Path) -> None:
    record = read_scene_record(root, 0)
    damaged, built = record.object(11), record.object(10)
    assert damaged is not None
    assert built is not None
    np.testing.assert_allclose(read_damaged_mesh(root, damaged).vertices, DAMAGED.mesh().vertices, atol=1e-6)
    assert read_damaged_mesh(root, built) is None


def test_validate_compares_damaged_targets_with_their_own_surface(root: Path, toy_root: Path) -> None:
    checks = {check.name: check for check in validate(root)}
    assert all(check.ok for check in checks.values()), [check for check in checks.values() if not check.ok]
    assert checks["damaged surfaces"].detail == "3 surfaces of damaged objects"
    plain = {check.name: check for check in validate(toy_root)}
    assert "damaged surfaces" not in plain
    assert checks["bop poses on images"].detail.split()[0] == plain["bop poses on images"].detail.split()[0]


def test_validate_misses_a_surface_and_finds_one_of_another_size(root: Path) -> None:
    path = root / "damaged" / f"{DAMAGED.name}.ply"
    kept = path.read_bytes()
    try:
        path.unlink()
        assert "is missing, scene" in failed(root)
        other = trimesh.creation.box((2000.0, 100.0, 100.0))
        write_ply(path, TriangleMesh(np.asarray(other.vertices, float), np.asarray(other.faces, np.int32)))
        assert "stands out of its object's box by" in failed(root)
        other = trimesh.creation.box((1000.0, 100.0, 100.0))
        write_ply(path, TriangleMesh(np.asarray(other.vertices, float), np.asarray(other.faces, np.int32)))
        assert "is not the file that SHA256SUMS lists" in failed(root)
    finally:
        path.write_bytes(kept)


def failed(root: Path) -> str:
    return next(check.detail for check in validate(root) if check.name == "damaged surfaces")
