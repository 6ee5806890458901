import numpy as np
import pytest

from warehouse_sim.generation.occlusion.drawing import OccluderStock
from warehouse_sim.generation.occlusion.occluder import Occluder
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.scene.unit_load import UnitLoadConfig

CARTONS = ("carton_600x400x300", "carton_400x300x200")


def drawn(kind: str, least: float, count: int, seed: int = 0) -> list[Occluder]:
    stock = OccluderStock(UnitLoadConfig(cartons=CARTONS, pallets=("epal1",)), np.random.default_rng(seed))
    return [item for item in (stock.draw(kind, least) for _ in range(count)) if item is not None]


@pytest.mark.parametrize("kind", ["load", "wrap", "pallet", "traffic"])
@pytest.mark.parametrize("least", [0.3, 1.9])
def test_occluders_stand_on_the_floor_and_are_high_enough(kind: str, least: float) -> None:
    found = drawn(kind, least, 5)
    assert len(found) >= 3
    for occluder in found:
        assert occluder.kind == kind
        assert occluder.height >= least
        low = BoxStack.of(occluder.boxes).extents()[0][:, 2].min()
        assert abs(low) < 0.0035  # a walking person's heel is a little up
        assert np.linalg.norm(occluder.envelope.T_parent_box[:2, 3]) < 0.35  # their frame is in their middle


def test_loads_are_made_of_the_recipes_goods() -> None:
    for kind in ("load", "wrap"):
        for occluder in drawn(kind, 0.5, 4):
            cartons = {name for name in occluder.models if name.startswith("carton")}
            assert cartons <= set(CARTONS)
            assert {name for name in occluder.models if occluder.models[name].class_name == "pallet"} <= {"epal1"}
            film = any(model.class_name == "wrap" for model in occluder.models.values())
            assert film == (kind == "wrap")


def test_nothing_of_the_catalog_is_four_metres_high() -> None:
    for kind in ("load", "wrap", "pallet", "traffic"):
        assert drawn(kind, 4.0, 2) == []


def test_the_same_stream_gives_the_same_occluders() -> None:
    one, two = (drawn("load", 1.0, 4, seed=5) for _ in range(2))
    for a, b in zip(one, two, strict=True):
        assert [item.model for item in a.instances] == [item.model for item in b.instances]
        for x, y in zip(a.instances, b.instances, strict=True):
            np.testing.assert_array_equal(x.T_world_object, y.T_world_object)
