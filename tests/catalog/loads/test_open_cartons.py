import numpy as np
import pytest

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.loads.open_cartons import OPEN_CARTONS
from warehouse_sim.catalog.loads.strength import bears
from warehouse_sim.catalog.shipped import SHIPPED


@pytest.mark.parametrize("name", OPEN_CARTONS)
def test_flaps_stay_over_the_carton_and_the_size_is_exact(name: str) -> None:
    model, closed = catalog_object(name), catalog_object(OPEN_CARTONS[name][0])
    np.testing.assert_array_equal(model.size[:2], closed.size[:2])
    flap = model.size[2] - closed.size[2]
    assert 0.3 * closed.size[1] / 2 < flap < closed.size[1] / 2 + 0.01
    assert model.mass < closed.mass
    assert bears(model) == 0.0
    assert model.class_name == "carton"


def test_numbers_are_their_own() -> None:
    numbers = [catalog_object(name).obj_id for name in OPEN_CARTONS]
    others = {catalog_object(name).obj_id for name in SHIPPED if name not in OPEN_CARTONS}
    assert len(set(numbers)) == len(numbers)
    assert set(numbers) <= set(range(930, 978))
    assert not others.intersection(numbers)
