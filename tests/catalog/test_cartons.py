import numpy as np
import pytest

from warehouse_sim.catalog import carton
from warehouse_sim.catalog.cartons import SKUS
from warehouse_sim.errors import UnknownNameError


@pytest.mark.parametrize("name", SKUS)
def test_outer_size_is_exact_and_part_of_the_name(name: str) -> None:
    model = carton(name)
    vertices = model.mesh().vertices
    np.testing.assert_allclose(vertices.max(axis=0) - vertices.min(axis=0), model.size, atol=1e-12)
    np.testing.assert_allclose(vertices.max(axis=0) + vertices.min(axis=0), 0.0, atol=1e-12)
    assert name == "carton_" + "x".join(str(round(1000 * edge)) for edge in model.size)
    np.testing.assert_array_equal(model.collision[0].size, model.size)


@pytest.mark.parametrize("name", SKUS)
def test_the_footprint_is_a_submultiple_of_the_600_x_400_module_and_tiles_the_pallet(name: str) -> None:
    length, width = (round(1000 * edge) for edge in carton(name).size[:2])
    assert 600 * 400 % (length * width) == 0
    assert 1200 * 800 % (length * width) == 0


@pytest.mark.parametrize("name", SKUS)
def test_a_carton_is_more_than_a_cube_and_weighs_what_people_lift(name: str) -> None:
    model = carton(name)
    assert len({part.material for part in model.parts}) == 3
    assert 1.0 < model.mass < 20.0


def test_numbers_are_fixed() -> None:
    assert {name: sku.obj_id for name, sku in SKUS.items()} == {
        "carton_600x400x400": 11,
        "carton_600x400x300": 12,
        "carton_600x400x220": 13,
        "carton_400x300x300": 14,
        "carton_400x300x200": 15,
        "carton_300x200x200": 16,
    }


def test_an_unknown_sku_lists_the_known_ones() -> None:
    with pytest.raises(UnknownNameError, match="carton_600x400x400"):
        carton("carton_1x1x1")
