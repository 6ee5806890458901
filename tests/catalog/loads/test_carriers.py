import numpy as np
import pytest

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.loads.strength import bears
from warehouse_sim.catalog.shipped import CARRIERS


@pytest.mark.parametrize("name", CARRIERS)
def test_a_carrier_stands_on_its_boxes_and_is_few_parts(name: str) -> None:
    model = catalog_object(name)
    corners = np.concatenate([box.corners() for box in model.collision])
    assert corners[:, 2].min() == pytest.approx(-model.size[2] / 2)
    assert len(model.mesh().faces) <= 7000
    assert len(model.parts) <= 12


def test_numbers_are_those_reserved_for_carriers_and_one_a_geometry() -> None:
    numbers = [catalog_object(name).obj_id for name in CARRIERS]
    assert len(set(numbers)) == len(CARRIERS)
    assert set(numbers) <= set(range(301, 400))


def test_standard_sizes_and_masses() -> None:
    assert catalog_object("gitterbox_empty").size.tolist() == [1.240, 0.835, 0.970]
    assert catalog_object("gitterbox_empty").mass == 70.0
    for name in CARRIERS:
        assert 30.0 < catalog_object(name).mass <= 1570.0
    assert catalog_object("ibc_1000").size[2] + catalog_object("epal3").size[2] == pytest.approx(1.16)


def test_boxes_of_steel_bear_stacks_and_bags_nothing() -> None:
    assert bears(catalog_object("gitterbox_cartons")) == 4400.0
    assert bears(catalog_object("ibc_1000")) > 3 * catalog_object("ibc_1000").mass
    assert bears(catalog_object("big_bag_1000x950x1200")) == 0.0
    assert bears(catalog_object("roll_container_full")) == 0.0
