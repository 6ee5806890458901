from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from tests.scene.raster import Pile, may_carry
from warehouse_sim.catalog.loads.sacks import SACKS, shapes_of
from warehouse_sim.catalog.shipped import CARRIERS
from warehouse_sim.errors import PlacementError
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.scene import Distribution
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.layouts.block_storage import floor_lanes
from warehouse_sim.scene.loads.lanes import STACKING_LOAD, LanesConfig, fill_lanes
from warehouse_sim.scene.loads.unit_load import UnitLoadConfig
from warehouse_sim.scene.packing.pallet_choice import WITHOUT_PALLET
from warehouse_sim.schema import ObjectInstance, ObjectModel

X = [-1.2, 0.0, 1.2]
GOODS = ("carton", "tote", "drum", "sack")
ONE = Distribution.constant(1.0)


def filled(seed: int, clear_height: float = 5.0, depth: int = 3, loads: UnitLoadConfig | None = None, **settings):
    lanes = floor_lanes(np.eye(4), X, depth, (1.4, 1.2), clear_height)
    draft = SceneDraft()
    fill_lanes(draft, lanes, LanesConfig(**settings), loads or UnitLoadConfig(), np.random.default_rng(seed))
    return draft


def article_of(model: ObjectModel) -> str:
    """Return the name of the article; sacks of one article are filled in several shapes."""
    return next((name for name in SACKS if model.name in shapes_of(name)), model.name)


def pallets(draft: SceneDraft) -> list[ObjectInstance]:
    return [item for item in draft.instances if draft.models[item.model].class_name == "pallet"]


def stacks(draft: SceneDraft) -> dict[tuple[int, int], list[ObjectInstance]]:
    """Return the pallets of each stack from the floor up, by lane and place."""
    found: dict[tuple[int, int], list[ObjectInstance]] = {}
    for item in sorted(pallets(draft), key=lambda item: float(item.T_world_object[2, 3])):
        x, y = item.T_world_object[:2, 3]
        found.setdefault((round(x / 1.2), int(y / 1.4)), []).append(item)
    return found


def test_lanes_are_filled_from_the_far_end() -> None:
    config = {"fill": Distribution.constant(0.67), "stack": Distribution.constant(1), "empties_fraction": 0.0}
    assert set(stacks(filled(0, **config))) == {(lane, place) for lane in (-1, 0, 1) for place in (1, 2)}


@pytest.mark.parametrize("seed", range(4))
def test_stacks_do_not_touch_and_each_load_begins_just_above_the_one_below(seed: int) -> None:
    draft = filled(seed, fill=Distribution.constant(1.0), stack=Distribution.choice(2, 3), empties_fraction=0.3)
    solids = draft.solids()
    group = {item.instance_id: item.group for item in draft.instances}
    groups, boxes = np.array([group[owner] for owner in solids.owner]), solids.boxes
    pairs = boxes.pairs(boxes, 0.05)
    pairs = pairs[groups[pairs[:, 0]] < groups[pairs[:, 1]]]
    assert boxes.separation(boxes, pairs).distance.min() >= -1e-9
    low, high = boxes.extents()
    for stack in stacks(draft).values():
        for below, above in pairwise(stack):
            top = high[groups == below.group, 2].max()
            assert 0.0 <= low[groups == above.group, 2].min() - top < 0.012


def test_a_stack_stays_under_the_roof_and_within_what_its_lowest_pallet_bears() -> None:
    for seed in range(3):
        draft = filled(seed, clear_height=2.5, fill=Distribution.constant(1.0), stack=Distribution.constant(4))
        _, high = draft.solids().extents
        assert 1.2 < high[:, 2].max() < 2.5
        for stack in stacks(draft).values():
            upper = {item.group for item in stack[1:]}
            mass = sum(draft.models[item.model].mass for item in draft.instances if item.group in upper)
            assert mass <= STACKING_LOAD


def test_empty_pallets_are_stacked_alone_and_of_one_kind() -> None:
    loads = UnitLoadConfig(pallets=("epal1", "plastic_runners"))
    draft = filled(
        1, loads=loads, empties_fraction=1.0, empties=Distribution.constant(6), fill=Distribution.constant(1.0)
    )
    assert len(draft.instances) == len(pallets(draft)) == 6 * 9
    for stack in stacks(draft).values():
        assert len({item.model for item in stack}) == 1


@pytest.mark.parametrize("recipe", ["block_storage", "dock_staging", "mixed_pallets"])
def test_a_lane_of_one_kind_holds_one_article_on_one_type_of_pallet(recipe: str) -> None:
    loads = load_recipe(recipe).scene.loads
    classes = set()
    for seed in range(3):
        config = {"one_kind_fraction": 1.0, "empties_fraction": 0.0, "fill": Distribution.constant(1.0)}
        draft = filled(seed, loads=loads, stack=Distribution.choice(1, 3), **config)
        for lane, x in enumerate(X):
            near = [item for item in draft.instances if abs(item.T_world_object[0, 3] - x) < 0.61]
            models = [draft.models[item.model] for item in near]
            goods = {article_of(model) for model in models if model.class_name in GOODS or model.name in CARRIERS}
            assert len(goods) == 1, lane
            on_pallets = not any(model.class_name in WITHOUT_PALLET for model in models)
            assert len({model.obj_id for model in models if model.class_name == "pallet"}) == on_pallets, lane
            classes |= {model.class_name for model in models}
    assert len(classes & set(GOODS)) >= 2  # lanes differ, as the recipe's shares say


def test_the_mix_of_goods_over_lanes_is_the_recipes() -> None:
    loads = replace(UnitLoadConfig(), tote_fraction=0.3, sack_fraction=0.2, empty_fraction=0.0)
    kinds = []
    for seed in range(60):
        draft = filled(seed, depth=1, loads=loads, one_kind_fraction=1.0, empties_fraction=0.0, fill=ONE, stack=ONE)
        places = {(round(item.T_world_object[0, 3] / 1.2), item.model) for item in draft.instances}
        kinds += [draft.models[name].class_name for _, name in places if draft.models[name].class_name in GOODS]
    assert len(kinds) == 180
    assert 0.2 < kinds.count("tote") / 180 < 0.4  # three standard deviations
    assert 0.11 < kinds.count("sack") / 180 < 0.29


@pytest.mark.parametrize("recipe", ["block_storage", "dock_staging", "mixed_pallets"])
def test_every_upper_load_rests_on_a_full_and_level_layer_that_bears_it(recipe: str) -> None:
    loads = load_recipe(recipe).scene.loads
    uppers = 0
    for seed in range(2):
        draft = filled(seed, loads=loads, fill=ONE, stack=Distribution.constant(4), empties_fraction=0.0)
        pile = Pile(draft.models, draft.instances)
        for number in pile.pallets():
            if pile.low[number] > 0.3:
                fraction, over = pile.supported(number)
                assert fraction >= 0.85
                assert over
                uppers += 1
        carried = pile.carried()
        cartons = [i for i, model in enumerate(pile.models) if model.class_name == "carton"]
        assert all(carried[i] <= may_carry(pile.models[i], pile.across(i)) for i in cartons)
    assert uppers >= 5


def test_a_lane_too_narrow_for_every_pallet_is_an_error() -> None:
    lanes = floor_lanes(np.eye(4), [0.0], 1, (1.3, 0.8), 4.0)
    with pytest.raises(PlacementError, match="widen the lanes"):
        fill_lanes(SceneDraft(), lanes, LanesConfig(), UnitLoadConfig(), np.random.default_rng(1))
