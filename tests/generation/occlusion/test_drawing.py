from dataclasses import replace

import numpy as np
import pytest

from tests.scene.raster import Pile, may_carry
from warehouse_sim.generation.occlusion.occluder import Occluder, OccluderSampler
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.scene.loads.unit_load import UnitLoadConfig
from warehouse_sim.scene.solids import Solids

CARTONS = ("carton_600x400x300", "carton_400x300x200")


def sampled(kind: str, least: float, count: int, seed: int = 0) -> list[Occluder]:
    sampler = OccluderSampler(UnitLoadConfig(cartons=CARTONS, pallets=("epal1",)), np.random.default_rng(seed))
    return [item for item in (sampler.sample(kind, least) for _ in range(count)) if item is not None]


@pytest.mark.parametrize("kind", ["load", "wrap", "pallet", "traffic"])
@pytest.mark.parametrize("least", [0.3, 1.9])
def test_occluders_stand_on_the_floor_and_are_high_enough(kind: str, least: float) -> None:
    found = [occluder for seed in range(4) for occluder in sampled(kind, least, 5, seed)]
    assert len(found) >= 8
    for occluder in found:
        assert occluder.kind == kind
        assert occluder.height >= least
        low = Solids.of(occluder.instances, occluder.models).extents[0][:, 2].min()
        assert abs(low) < 0.0035  # a walking person's heel is a little up
        assert np.linalg.norm(occluder.envelope.T_parent_box[:2, 3]) < 0.35  # their frame is in their middle


def test_loads_are_made_of_the_recipes_goods() -> None:
    for kind in ("load", "wrap"):
        for occluder in sampled(kind, 0.5, 4):
            cartons = {name for name in occluder.models if name.startswith("carton")}
            assert cartons <= set(CARTONS)
            assert {name for name in occluder.models if occluder.models[name].class_name == "pallet"} <= {"epal1"}
            film = any(model.class_name == "wrap" for model in occluder.models.values())
            assert film == (kind == "wrap")


def test_nothing_of_the_catalog_is_four_metres_high() -> None:
    for kind in ("load", "wrap", "pallet", "traffic"):
        assert sampled(kind, 4.0, 2) == []


def test_the_same_stream_gives_the_same_occluders() -> None:
    one, two = (sampled("load", 1.0, 4, seed=5) for _ in range(2))
    for a, b in zip(one, two, strict=True):
        assert [item.model for item in a.instances] == [item.model for item in b.instances]
        for x, y in zip(a.instances, b.instances, strict=True):
            np.testing.assert_array_equal(x.T_world_object, y.T_world_object)


@pytest.mark.parametrize(
    ("recipe", "height"),
    [
        ("industrial", 1.3), ("mixed_pallets", 2.2), ("block_storage", 2.2),
        *(pytest.param(*pair, marks=pytest.mark.slow) for pair in
          (("industrial", 2.2), ("mixed_pallets", 1.3), ("block_storage", 1.3))),
    ],
)  # fmt: skip
def test_an_upper_load_stands_on_a_full_and_level_layer_that_bears_it(recipe: str, height: float) -> None:
    # Loads come out low, so that one that should be high enough alone needs another below it, too.
    loads = replace(load_recipe(recipe).scene.loads, max_cartons=16)
    pairs = 0
    for seed in range(5):
        sampler = OccluderSampler(loads, np.random.default_rng(seed))
        for occluder in filter(None, (sampler.sample("wrap", height), sampler.unit_load(height))):
            pile = Pile(occluder.models, occluder.instances)
            for upper in pile.pallets()[1:]:
                fraction, over = pile.supported(upper)
                assert fraction >= 0.85
                assert over
                pairs += 1
            carried = pile.carried()
            for number, model in enumerate(pile.models):
                if model.class_name == "carton":
                    assert carried[number] <= may_carry(model, pile.across(number))
    assert pairs >= 4


def test_a_column_is_no_higher_than_its_lowest_piece_bears() -> None:
    heavy = replace(load_recipe("industrial").scene.loads, totes=("tote_600x400x147_grey",))
    sampler = OccluderSampler(heavy, np.random.default_rng(0))
    for _ in range(20):
        column = sampler.column(1.9)
        assert column is not None
        carried = sum(column.models[item.model].mass for item in column.instances[1:])
        name = column.instances[0].model
        assert not name.startswith("carton") or carried <= may_carry(column.models[name], across=False)
