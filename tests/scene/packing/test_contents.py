import itertools
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from tests.scene.packing.pallets import DECKS, least_distance, reach
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.loads.cartons import SKUS
from warehouse_sim.catalog.loads.drums import DRUMS
from warehouse_sim.catalog.loads.sacks import SACKS
from warehouse_sim.catalog.loads.strength import is_fragile
from warehouse_sim.catalog.loads.totes import TOTES
from warehouse_sim.catalog.shipped import CARRIERS
from warehouse_sim.errors import ConfigError, PlacementError
from warehouse_sim.generation.plan import target_models
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.scene import Distribution
from warehouse_sim.scene.loads.unit_load import build_unit_load
from warehouse_sim.scene.packing.contents import Goods, LoadSpace, sample_goods
from warehouse_sim.scene.packing.load_config import SampledPalletsConfig, UnitLoadConfig, WearRange
from warehouse_sim.scene.packing.pallet_choice import all_pallets, on_these, sample_carrier, sample_pallet
from warehouse_sim.scene.packing.patterns import PATTERNS
from warehouse_sim.scene.packing.stacking import StackingConfig

SPACE = LoadSpace((1.2, 0.8), 1.6, 1500.0)
CONFIG = UnitLoadConfig(
    patterns=PATTERNS,
    height=Distribution.uniform(0.3, 1.5),
    max_cartons=60,
    stacking=StackingConfig(gap_mm=4.0, shift_mm=Distribution.normal(0, 0.7, -1.5, 1.5), half_turn_fraction=0.5),
)
KINDS = {
    "cartons": CONFIG,
    "mixed": replace(CONFIG, mixed_fraction=1.0),
    "totes": replace(CONFIG, tote_fraction=1.0),
    "drums": replace(CONFIG, drum_fraction=1.0, drums=("drum_plastic_60_blue", "drum_plastic_60_white")),
    "sacks": replace(CONFIG, sack_fraction=1.0),
}


def outlines(goods: Goods) -> list[OrientedBox]:
    """Return the pieces' boxes; a round piece has the box that does not turn with it."""
    boxes = []
    for model, T in goods:
        upright = T.copy()
        if model.class_name == "drum":
            upright[:3, :3] = np.eye(3)
        boxes.append(OrientedBox(upright, model.size))
    return boxes


def test_goods_never_overlap_on_any_pallet() -> None:
    for deck, kind, seed in itertools.product(DECKS, KINDS, range(2)):
        space = replace(SPACE, area=deck)
        goods = sample_goods(space, KINDS[kind], np.random.default_rng(seed))
        boxes = outlines(goods)
        assert least_distance(boxes) >= 0.0005 - 1e-9, (deck, kind, seed)
        assert np.all(reach(boxes) <= np.array(deck) / 2 + 0.004 * np.array(deck) / 0.2 + 0.01), (deck, kind, seed)
        corners = np.concatenate([box.corners() for box in boxes])
        assert corners[:, 2].min() > 0.0, (deck, kind, seed)
        assert corners[:, 2].max() <= space.height + 0.01, (deck, kind, seed)
        assert sum(model.mass for model, _ in goods) <= space.payload, (deck, kind, seed)


@pytest.mark.parametrize(("kind", "names"), [("totes", TOTES), ("drums", DRUMS), ("sacks", SACKS), ("mixed", SKUS)])
def test_goods_come_from_the_list_of_their_kind(kind: str, names: dict) -> None:
    for seed in range(10):
        assert {model.name for model, _ in sample_goods(SPACE, KINDS[kind], np.random.default_rng(seed))} <= set(names)


def test_a_mixed_load_holds_several_skus_and_others_one() -> None:
    mixed = [len({m.name for m, _ in sample_goods(SPACE, KINDS["mixed"], np.random.default_rng(s))}) for s in range(8)]
    equal = [len({m.name for m, _ in sample_goods(SPACE, CONFIG, np.random.default_rng(s))}) for s in range(8)]
    assert max(mixed) >= 3
    assert set(equal) == {1}


def test_shares_are_kept() -> None:
    config = replace(CONFIG, tote_fraction=0.3, sack_fraction=0.2)
    rng = np.random.default_rng(0)
    kinds = [sample_goods(SPACE, replace(config, max_cartons=1), rng)[0][0].class_name for _ in range(200)]
    assert 0.17 < kinds.count("tote") / 200 < 0.43  # four standard deviations
    assert 0.09 < kinds.count("sack") / 200 < 0.31
    assert kinds.count("drum") == 0


def test_weight_limits_the_layers() -> None:
    config = replace(KINDS["sacks"], height=Distribution.constant(1.5))
    heavy = sample_goods(replace(SPACE, payload=410.0), config, np.random.default_rng(0))
    assert 200.0 < sum(model.mass for model, _ in heavy) <= 410.0


def test_what_fits_nowhere_is_an_error_that_says_what_to_do() -> None:
    with pytest.raises(PlacementError, match="list smaller, lower or lighter goods"):
        sample_goods(replace(SPACE, height=0.1), CONFIG, np.random.default_rng(0))
    with pytest.raises(PlacementError, match="at most 100 kg"):
        sample_goods(replace(SPACE, payload=100.0), replace(CONFIG, drum_fraction=1.0), np.random.default_rng(0))


def test_modular_cartons_of_a_picked_order_stand_side_by_side_in_spite_of_gaps() -> None:
    config = replace(
        KINDS["mixed"], cartons=("carton_600x400x400", "carton_600x400x300"), stacking=StackingConfig(), max_cartons=8
    )
    for seed in range(5):
        goods = sample_goods(replace(SPACE, height=0.45), config, np.random.default_rng(seed))
        assert len(goods) == 4


def test_under_the_crush_rule_fragile_cartons_are_on_top_and_heavier_ones_below() -> None:
    config = replace(CONFIG, mixed_fraction=1.0, max_cartons=40, height=Distribution.constant(1.2))
    rested = 0
    for seed in range(12):
        pieces = sample_goods(SPACE, config, np.random.default_rng(seed))
        for upper, T_upper in pieces:
            for lower, T_lower in pieces:
                off = np.abs(T_upper[:2, 3] - T_lower[:2, 3])
                gap = (T_upper[2, 3] - upper.size[2] / 2) - (T_lower[2, 3] + lower.size[2] / 2)
                if abs(gap) < 0.002 and np.all(off < (np.min(upper.size[:2]) + np.min(lower.size[:2])) / 2 - 0.02):
                    rested += 1
                    assert not is_fragile(lower)
                    assert upper.mass <= lower.mass
    assert rested > 20


def test_a_load_of_fragile_cartons_is_one_layer_and_is_drawn_only_where_nothing_else_is_listed() -> None:
    fragile = tuple(name for name in SKUS if is_fragile(catalog_object(name)))
    assert len(fragile) == 5
    config = replace(CONFIG, height=Distribution.constant(1.2), cartons=fragile)
    assert len({round(T[2, 3], 2) for _, T in sample_goods(SPACE, config, np.random.default_rng(0))}) == 1
    both = replace(config, cartons=(*fragile, "carton_400x300x200"))
    assert {sample_goods(SPACE, both, np.random.default_rng(seed))[0][0].name for seed in range(9)} == {
        "carton_400x300x200"
    }


def test_without_the_crush_rule_fragile_cartons_are_stacked_as_they_were() -> None:
    off = replace(CONFIG.stacking, crush_rule=False)
    config = replace(CONFIG, height=Distribution.constant(1.2), cartons=("carton_600x400x350",), stacking=off)
    assert len({round(T[2, 3], 2) for _, T in sample_goods(SPACE, config, np.random.default_rng(0))}) == 3


# Pallets of the catalog and pallets that are in none, drawn for loads.


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
