"""Pallets of the catalog and pallets that are in none, drawn for loads."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.shipped import CARRIERS
from warehouse_sim.errors import ConfigError, PlacementError
from warehouse_sim.generation.plan import target_models
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.scene import Distribution
from warehouse_sim.scene.loads.unit_load import build_unit_load
from warehouse_sim.scene.packing.load_config import SampledPalletsConfig, UnitLoadConfig, WearRange
from warehouse_sim.scene.packing.pallet_choice import all_pallets, on_these, sample_carrier, sample_pallet

LOADS = UnitLoadConfig(pallets=("epal1", "epal3"), sampled_pallets=SampledPalletsConfig(count=5, fraction=0.4))


def test_the_fraction_of_sampled_pallets_is_as_requested() -> None:
    rng = np.random.default_rng(0)
    names = Counter(sample_pallet(LOADS, rng).name for _ in range(2000))
    sampled = sum(count for name, count in names.items() if name.startswith("sampled_pallet"))
    assert sampled / 2000 == pytest.approx(0.4, abs=0.04)
    assert len(names) == 7


def test_without_sampled_pallets_the_stream_is_that_of_a_choice_of_names() -> None:
    loads = UnitLoadConfig(pallets=("epal1", "epal2", "epal3"))
    first, second = np.random.default_rng(7), np.random.default_rng(7)
    assert [sample_pallet(loads, first).name for _ in range(20)] == [
        str(second.choice(loads.pallets)) for _ in range(20)
    ]


def test_what_does_not_fit_is_not_drawn() -> None:
    rng, footprint = np.random.default_rng(1), (1.2, 0.85)
    found = [sample_pallet(LOADS, rng, footprint) for _ in range(50)]
    assert all(np.all(model.size[:2] <= np.array(footprint) + 1e-6) for model in found)
    with pytest.raises(PlacementError, match=r"loads\.pallets"):
        sample_pallet(LOADS, rng, (0.3, 0.3))


def test_loads_can_be_kept_to_one_sampled_pallet() -> None:
    one = all_pallets(LOADS)[4]
    only = on_these(LOADS, [one])
    assert {sample_pallet(only, np.random.default_rng(i)).name for i in range(9)} == {one.name}
    assert [model.obj_id for model in all_pallets(only)] == [one.obj_id]


def test_wear_is_drawn_from_its_ranges() -> None:
    wear = WearRange(broken=Distribution.constant(0.25)).sampled(np.random.default_rng(0))
    assert wear.broken == 0.25
    assert 0.1 <= wear.age <= 1.0


EVERY = UnitLoadConfig(carrier_fraction=1.0)


def carriers_drawn(
    headroom: float = 3.0, footprint: tuple[float, float] | None = None, on_floor: bool = True
) -> set[str]:
    rng = np.random.default_rng(0)
    found = [sample_carrier(EVERY, rng, headroom, footprint, np.inf, on_floor) for _ in range(100)]
    return {pair[0].name for pair in found if pair is not None}


def test_every_carrier_is_drawn_where_there_is_room() -> None:
    assert carriers_drawn() == set(CARRIERS)


def test_roll_containers_stand_on_the_floor_only_and_places_limit_what_fits() -> None:
    assert not any(name.startswith("roll") for name in carriers_drawn(on_floor=False))
    assert all(name.startswith("gitterbox") for name in carriers_drawn(headroom=1.0))
    for name in carriers_drawn(footprint=(1.2, 0.8)):
        assert name.startswith("roll") or catalog_object(name).size[1] <= 0.82
    assert carriers_drawn(headroom=0.5) == set()


def test_a_carrier_stands_on_a_pallet_that_it_fits_or_on_its_own_feet() -> None:
    for seed in range(30):
        load = build_unit_load(3.0, EVERY, np.random.default_rng(seed), on_floor=True)
        carrier, T = load.pieces[-1]
        assert carrier.name in CARRIERS
        assert T[2, 3] - carrier.size[2] / 2 == pytest.approx(load.height - carrier.size[2], abs=1e-6)
        if len(load.pieces) == 2:
            assert np.all(carrier.size[:2] <= load.pallet.size[:2] + 0.02)
        else:
            assert carrier.class_name in ("gitterbox", "roll_container")


def test_without_a_share_nothing_of_the_stream_is_used() -> None:
    plain, listed = UnitLoadConfig(), UnitLoadConfig(carriers=("ibc_1000",))
    first, second = (build_unit_load(1.5, config, np.random.default_rng(4)) for config in (plain, listed))
    assert [T.tolist() for _, T in first.pieces] == [T.tolist() for _, T in second.pieces]


def test_a_name_that_is_no_carrier_is_rejected() -> None:
    with pytest.raises((ConfigError, ValueError), match="epal1"):
        replace(EVERY, carriers=("epal1",))


def test_every_pallet_under_a_carrier_is_among_the_models_of_a_dataset() -> None:
    known = {model.obj_id for model in target_models(load_recipe("block_storage"))}
    loads = replace(load_recipe("block_storage").scene.loads, carrier_fraction=1.0)
    for seed in range(40):
        pallet = build_unit_load(3.0, loads, np.random.default_rng(seed)).pallet
        assert pallet.class_name != "pallet" or pallet.obj_id in known
