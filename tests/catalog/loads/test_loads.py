import numpy as np

from tests.catalog.covering import shipped
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.loads.cartons import HEAVY_SKUS, SKUS
from warehouse_sim.catalog.loads.drums import DRUMS
from warehouse_sim.catalog.loads.open_cartons import OPEN_CARTONS
from warehouse_sim.catalog.loads.sacks import SACK_SHAPES, SACKS
from warehouse_sim.catalog.loads.securing import CORNER_POSTS, SLIP_SHEETS, WRAPS
from warehouse_sim.catalog.loads.totes import TOTES
from warehouse_sim.catalog.shipped import CARRIERS

CLASSES = {
    "carton": SKUS,
    "tote": TOTES,
    "drum": DRUMS,
    "sack": SACKS,
    "slip_sheet": SLIP_SHEETS,
    "corner_post": CORNER_POSTS,
    "wrap": WRAPS,
}

LOADS = shipped("loads")
_FURTHER = {*CARRIERS, *SACK_SHAPES, *HEAVY_SKUS, *OPEN_CARTONS}


def test_every_load_has_the_class_of_its_list() -> None:
    assert {name for names in CLASSES.values() for name in names} == set(LOADS) - _FURTHER
    for class_name, names in CLASSES.items():
        assert {catalog_object(name).class_name for name in names} == {class_name}


def test_numbers_are_those_reserved_for_loads_and_one_a_geometry() -> None:
    numbers = {name: catalog_object(name).obj_id for name in LOADS if name not in _FURTHER}
    assert set(numbers.values()) <= set(range(11, 61))
    families = {name: tuple(catalog_object(name).size) for name in LOADS}
    assert len({(number, families[name]) for name, number in numbers.items()}) == len(set(numbers.values()))


def test_goods_stand_on_their_whole_box() -> None:
    for name in [*SKUS, *HEAVY_SKUS, *TOTES, *SACKS]:
        model = catalog_object(name)
        base, *others = model.collision
        np.testing.assert_array_equal(base.size[:2], model.size[:2], err_msg=name)
        assert base.corners()[:, 2].min() == -model.size[2] / 2, name
        is_open = name in TOTES and "lid" not in name
        assert bool(others) == is_open, name
        if not is_open:
            np.testing.assert_array_equal(base.size, model.size, err_msg=name)


def test_a_load_is_few_parts_and_not_too_many_triangles() -> None:
    for name in set(LOADS) - _FURTHER:
        model = catalog_object(name)
        assert len(model.parts) <= 7, name
        assert len(model.mesh().faces) <= 3500, name
