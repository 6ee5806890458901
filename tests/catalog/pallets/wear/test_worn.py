from dataclasses import fields, replace

import numpy as np
import pytest

from tests.catalog.pallets.touching import hits, is_closed, prism_of
from tests.catalog.pallets.wear.used import KINDS, ruined
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.materials import materials
from warehouse_sim.catalog.pallets import PALLETS
from warehouse_sim.catalog.pallets.wear.damage import FARTHEST
from warehouse_sim.catalog.pallets.wear.damaged import WearConfig, damaged
from warehouse_sim.schema.things import is_damaged

ALL = WearConfig(**dict.fromkeys((item.name for item in fields(WearConfig)), 1.0))


@pytest.mark.parametrize("name", PALLETS)
def test_the_meaning_stays(name: str) -> None:
    new, old = catalog_object(name), ruined(name, 1, ALL)
    assert old.name.startswith(f"{name}~")
    for field in ("class_name", "obj_id", "mass", "size", "pockets", "symmetry", "collision"):
        assert getattr(old, field) is getattr(new, field)


@pytest.mark.parametrize("name", PALLETS)
def test_a_pallet_is_called_damaged_only_where_its_surface_is_another(name: str) -> None:
    new, old = catalog_object(name).mesh(), ruined(name, 1, ALL)
    same = np.array_equal(new.faces, old.mesh().faces) and np.allclose(new.vertices, old.mesh().vertices)
    assert is_damaged(old.name) != same
    assert is_damaged(name) is False


@pytest.mark.parametrize("name", KINDS)
def test_pockets_shrunk_by_15_mm_stay_free(name: str) -> None:
    for seed in range(8):
        model = ruined(name, seed, ALL)
        for pocket in model.pockets:
            assert not hits(model, *prism_of(pocket, (0.0, -0.030, -0.030)))


def test_wear_does_reach_into_the_pockets_a_little() -> None:
    intruding = [
        hits(model, *prism_of(pocket, (0.0, -0.002, -0.002)))
        for model in (ruined("epal1", seed, ALL) for seed in range(4))
        for pocket in model.pockets
    ]
    assert any(intruding)


@pytest.mark.parametrize("name", KINDS)
def test_nothing_stands_out_by_more_than_a_twisted_block_may(name: str) -> None:
    for seed in range(8):
        vertices = ruined(name, seed, ALL).mesh().vertices
        half = catalog_object(name).size / 2
        assert np.all(np.abs(vertices[:, :2]) <= half[:2] + FARTHEST + 1e-3)
        assert np.all(np.abs(vertices[:, 2]) <= half[2] + 5e-4)


@pytest.mark.parametrize("name", PALLETS)
def test_every_part_is_closed_and_its_material_exists(name: str) -> None:
    for part in ruined(name, 6, ALL).parts:
        assert part.material in materials()
        assert is_closed(part.mesh)


def test_meshes_are_shared_between_damaged_pallets() -> None:
    pallets = [ruined("epal1", seed, WearConfig(age=0.5, stains=1.0)) for seed in range(20)]
    assert len({part.mesh for model in pallets for part in model.parts}) < 25


def test_the_same_stream_wears_alike_and_another_does_not() -> None:
    one, two, other = ruined("epal3", 1, ALL), ruined("epal3", 1, ALL), ruined("epal3", 2, ALL)
    assert one.name == two.name != other.name
    np.testing.assert_array_equal(one.mesh().vertices, two.mesh().vertices)
    assert one.mesh().vertices.shape != other.mesh().vertices.shape


def test_a_share_out_of_range_is_rejected() -> None:
    with pytest.raises(ValueError, match=r"broken must be 0-1, found 1\.5"):
        WearConfig(broken=1.5)


@pytest.mark.parametrize("name", ["epal1", "blue_block_1200x1000", "plastic_runners", "gma_48x40"])
def test_what_use_does_to_a_pallet_does_not_depend_on_what_it_is_called(name: str) -> None:
    model = catalog_object(name)
    wear = WearConfig(age=0.0, missing=0.6, broken=0.5, displaced=0.5, twisted=0.5, stamps=1.0)
    one = damaged(model, wear, np.random.default_rng(3))
    other = damaged(replace(model, name="plastic_of_my_own"), wear, np.random.default_rng(3))
    assert [part.material for part in one.parts] == [part.material for part in other.parts]
    for mine, theirs in zip(one.parts, other.parts, strict=True):
        np.testing.assert_array_equal(mine.T_object_part, theirs.T_object_part)


def test_pieces_without_a_role_stay_where_they_are() -> None:
    model = catalog_object("epal1")
    plain = replace(model, make="", parts=tuple(replace(part, role="") for part in model.parts))
    used = damaged(plain, WearConfig(missing=1.0, broken=1.0, displaced=1.0, twisted=1.0), np.random.default_rng(0))
    for before, after in zip(plain.parts, used.parts, strict=True):
        np.testing.assert_array_equal(before.T_object_part, after.T_object_part)
