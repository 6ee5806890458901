"""Pallets of the catalog and pallets that are in none, drawn for loads."""

from collections import Counter

import numpy as np
import pytest

from warehouse_sim.errors import PlacementError
from warehouse_sim.scene.packing.load_config import UnitLoadConfig
from warehouse_sim.scene.packing.pallet_choice import all_pallets, on_these, sample_pallet
from warehouse_sim.scene.packing.sampled_pallets import SampledPalletsConfig

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
