"""Numbers of an object against its surface, where the ground truth is known in closed form."""

import shutil
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from tests.dataset.toy import CARTON, PALLET
from warehouse_sim.catalog import catalog_object
from warehouse_sim.dataset.files.ply import read_ply, write_ply
from warehouse_sim.dataset.formats.bop import bop_layout
from warehouse_sim.dataset.formats.bop.models import write_models
from warehouse_sim.dataset.formats.bop.reader import read_model
from warehouse_sim.dataset.object_gt import geometry_problems, hull_corners
from warehouse_sim.dataset.objects import ObjectInfo, read_objects, write_objects
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.symmetry import SymmetryGroup

MODELS = (PALLET, CARTON, catalog_object("gma_48x40"), catalog_object("plastic_nestable"))


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The files of some objects, to read only."""
    folder = tmp_path_factory.mktemp("objects")
    (folder / "bop").mkdir()
    write_objects(folder, MODELS)
    write_models(folder / "bop", MODELS)
    for kind in ("models", "models_eval"):
        (folder / "bop" / kind / "SHA256SUMS").unlink()
    return folder


@pytest.fixture
def infos(written: Path, tmp_path: Path) -> dict[int, ObjectInfo]:
    """What a dataset of some objects says, its meshes changeable."""
    shutil.copytree(written, tmp_path, dirs_exist_ok=True)
    return read_objects(tmp_path, partial(read_model, bop_layout(tmp_path)))


def test_true_numbers_are_believed(infos: dict[int, ObjectInfo]) -> None:
    assert {obj_id: geometry_problems(info) for obj_id, info in infos.items()} == {model.obj_id: [] for model in MODELS}


@pytest.mark.parametrize(
    "symmetry",
    [
        SymmetryGroup.turns("z", 4),
        SymmetryGroup.turns("z", 3),
        SymmetryGroup.turns("z", 36),
        pytest.param(SymmetryGroup.turns("z", 360), marks=pytest.mark.slow),
        SymmetryGroup.cuboid(),
    ],
)
def test_false_symmetries_are_found(infos: dict[int, ObjectInfo], symmetry: SymmetryGroup) -> None:
    """An oblong pallet has its half turn; no cuboid looks the same from below when it is one."""
    problems = geometry_problems(replace(infos[PALLET.obj_id], symmetry=symmetry))
    assert any("moves the surface elsewhere" in problem for problem in problems)
    assert not any("symmetries[0] " in problem for problem in problems)


def test_a_small_turn_is_no_group(infos: dict[int, ObjectInfo]) -> None:
    few = SymmetryGroup(SymmetryGroup.turns("z", 360).transforms[:2])
    assert "symmetries are not closed under composition" in geometry_problems(
        replace(infos[PALLET.obj_id], symmetry=few)
    )


@pytest.mark.parametrize(("factor", "wrong"), [(1.0, False), (1.005, False), (1.02, True), (0.98, True)])
def test_the_diameter_is_the_farthest_pair(infos: dict[int, ObjectInfo], factor: float, wrong: bool) -> None:
    """The corners of a box are the root of its squared edges apart."""
    info = replace(infos[CARTON.obj_id], diameter=factor * float(np.linalg.norm([0.4, 0.3, 0.25])))
    assert any(problem.startswith("diameter is") for problem in geometry_problems(info)) == wrong


@pytest.mark.parametrize("kind", ["models", "models_eval"])
def test_a_dent_in_one_mesh_is_found(infos: dict[int, ObjectInfo], tmp_path: Path, kind: str) -> None:
    path = tmp_path / "bop" / kind / f"obj_{PALLET.obj_id:06d}.ply"
    mesh = read_ply(path)
    vertices = mesh.vertices.copy()
    vertices[0] *= 0.99
    write_ply(path, TriangleMesh(vertices, mesh.faces))
    assert any("are not the same surface" in problem for problem in geometry_problems(infos[PALLET.obj_id]))


def test_points_of_one_plane_are_their_own_hull() -> None:
    flat = np.array([[0.0, 0, 0], [1, 0, 1], [0, 1, 0], [1, 1, 1], [0.5, 0.5, 0.5]])
    assert np.array_equal(hull_corners(flat), flat)
