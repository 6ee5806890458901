import numpy as np

from warehouse_sim.catalog import catalog_object
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.physics.rest import find_stacks
from warehouse_sim.scene.solids import Solids
from warehouse_sim.schema import ObjectInstance

CARTON = "carton_600x400x400"


def stacks_of(*placed: tuple[str, float, float, int]) -> list[list[int]]:
    """Return instance ids by stack of loose objects given as (name, x, z of the underside, group)."""
    items = []
    for index, (name, x, z, group) in enumerate(placed):
        centre = np.array([x, 0.0, z + catalog_object(name).size[2] / 2])
        items.append(ObjectInstance(index + 1, name, make_transform(translation=centre), dynamic=True, group=group))
    models = {item.model: catalog_object(item.model) for item in items}
    return [[item.instance_id for item in stack] for stack in find_stacks(items, Solids.of(items, models))]


def test_the_pieces_of_a_load_settle_together_and_neighbours_apart() -> None:
    assert stacks_of(("epal1", 0.0, 0.0, 1), (CARTON, 0.0, 0.145, 1), ("epal1", 1.21, 0.0, 2)) == [[1, 2], [3]]


def test_loads_on_each_other_are_one_stack() -> None:
    tower = (("epal1", 0.0, 0.0, 1), (CARTON, 0.0, 0.145, 1), ("epal1", 0.1, 0.555, 2), ("epal1", 0.1, 0.71, 3))
    assert stacks_of(*tower) == [[1, 2, 3, 4]]


def test_a_load_high_above_another_is_not_on_it() -> None:
    assert stacks_of(("epal1", 0.0, 0.0, 1), ("epal1", 0.0, 1.45, 2)) == [[1], [2]]


def test_the_lowest_stack_comes_first_and_things_without_a_group_are_loads_of_their_own() -> None:
    assert stacks_of(("epal1", 0.0, 2.0, 1), ("epal1", 3.0, 0.0, 0), ("epal1", 6.0, 0.0, 0)) == [[2], [3], [1]]


def test_nothing_loose_is_no_stack() -> None:
    assert find_stacks((), Solids.of((), {})) == []
