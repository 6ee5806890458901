import itertools
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
from warehouse_sim.errors import PlacementError
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.scene import Distribution
from warehouse_sim.scene.packing.contents import Goods, LoadSpace, sample_goods
from warehouse_sim.scene.packing.load_config import UnitLoadConfig
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
