from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.shipped import CARRIERS
from warehouse_sim.errors import ConfigError
from warehouse_sim.generation.plan import target_models
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.scene.packing.carriers import sample_carrier
from warehouse_sim.scene.unit_load import UnitLoadConfig, build_unit_load

EVERY = UnitLoadConfig(carrier_fraction=1.0)


def sampled(headroom: float = 3.0, footprint: tuple[float, float] | None = None, on_floor: bool = True) -> set[str]:
    rng = np.random.default_rng(0)
    found = [sample_carrier(EVERY, rng, headroom, footprint, np.inf, on_floor) for _ in range(200)]
    return {pair[0].name for pair in found if pair is not None}


def test_every_carrier_is_drawn_where_there_is_room() -> None:
    assert sampled() == set(CARRIERS)


def test_roll_containers_stand_on_the_floor_only_and_places_limit_what_fits() -> None:
    assert not any(name.startswith("roll") for name in sampled(on_floor=False))
    assert all(name.startswith("gitterbox") for name in sampled(headroom=1.0))
    for name in sampled(footprint=(1.2, 0.8)):
        assert name.startswith("roll") or catalog_object(name).size[1] <= 0.82
    assert sampled(headroom=0.5) == set()


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
