import itertools
from dataclasses import replace

import numpy as np
import pytest

from tests.scene.packing.pallets import DECKS, least_distance, reach
from tests.scene.raster import may_carry
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.loads.cartons import SKUS
from warehouse_sim.catalog.loads.strength import stacking_strength
from warehouse_sim.errors import PlacementError
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z
from warehouse_sim.scene import Distribution
from warehouse_sim.scene.packing.bearing import bearing, supported_fraction, without_overload
from warehouse_sim.scene.packing.patterns import PATTERNS, pattern_layers
from warehouse_sim.scene.packing.stacking import StackingConfig, Tier, stack_tiers

FULL = StackingConfig(top_layer_fraction=Distribution.constant(1.0))
ROUGH = replace(FULL, half_turn_fraction=0.5)


def tiers(
    size: np.ndarray, count: int, deck: tuple[float, float], pattern: str = "column", gap: float = 0.008
) -> list[Tier]:
    cycle = pattern_layers(pattern, size, deck, gap)  # type: ignore[arg-type]
    return [Tier(size, cycle[i % len(cycle)]) for i in range(count)] if cycle else []


def boxes(stack: list[Tier], poses: list[list[Transform]]) -> list[OrientedBox]:
    return [OrientedBox(T, tier.size) for tier, layer in zip(stack, poses, strict=True) for T in layer]


def test_nothing_overlaps_and_nothing_leaves_the_overhang() -> None:
    for deck, seed in itertools.product(DECKS, range(12)):
        rng = np.random.default_rng(seed)
        name, pattern = str(rng.choice(list(SKUS))), str(rng.choice(PATTERNS))
        size = catalog_object(name).size
        stack = tiers(size, 4, deck, pattern)
        if not stack:
            stack = tiers(size, 4, deck)
        placed = boxes(stack, stack_tiers(stack, ROUGH, rng))
        assert least_distance(placed) >= 0.0005 - 1e-9, (deck, seed)
        pieces = np.array(deck) // min(size[:2])
        jitter = 0.004 + 3 * 0.012 + np.sin(np.deg2rad(1.5)) * size[0] / 2
        assert np.all(reach(placed) <= np.array(deck) / 2 + 0.008 * pieces + jitter), (deck, seed)


@pytest.mark.parametrize("sku", ["carton_600x400x400", "carton_300x200x200"])
def test_each_layer_is_half_a_millimetre_over_the_one_below(sku: str) -> None:
    size = catalog_object(sku).size
    stack = tiers(size, 3, (1.2, 0.8))
    heights = [{round(T[2, 3], 9) for T in layer} for layer in stack_tiers(stack, FULL, np.random.default_rng(0))]
    assert heights == [{round(size[2] / 2 + 0.0005 + i * (size[2] + 0.0005), 9)} for i in range(3)]


def test_no_pose_is_drawn_tilted() -> None:
    stack = tiers(catalog_object("carton_400x300x250").size, 5, (1.2, 0.8), "interlock")
    for layer in stack_tiers(stack, ROUGH, np.random.default_rng(3)):
        np.testing.assert_allclose([T[2, :3] for T in layer], [[0.0, 0.0, 1.0]] * len(layer), atol=1e-15)


def test_the_top_layer_is_taken_in_part_anywhere_or_from_one_side() -> None:
    stack = tiers(catalog_object("carton_400x300x200").size, 2, (1.2, 0.8))
    half = replace(FULL, top_layer_fraction=Distribution.constant(0.5))
    assert [len(layer) for layer in stack_tiers(stack, half, np.random.default_rng(0))] == [8, 4]
    none = replace(FULL, top_layer_fraction=Distribution.constant(0.0))
    assert [len(layer) for layer in stack_tiers(stack[:1], none, np.random.default_rng(0))] == [1]
    for seed in range(8):
        top = stack_tiers(stack, replace(half, top_layer_order="rows"), np.random.default_rng(seed))[1]
        spread = np.ptp([T[:2, 3] for T in top], axis=0)
        assert spread.min() < 0.42  # four of the eight cells that are next to each other


def test_round_pieces_are_turned_any_way_inside_their_cell() -> None:
    size = np.array([0.4, 0.4, 0.6])
    cells = pattern_layers("column", size, (1.2, 0.8), 0.003)[0]
    poses = stack_tiers(
        [Tier(size, cells, is_round=True)],
        replace(FULL, gap_mm=3.0, shift_mm=Distribution.normal(0, 0.4, -1, 1)),
        np.random.default_rng(0),
    )[0]
    yaws = np.array([np.arctan2(T[1, 0], T[0, 0]) for T in poses])
    assert np.ptp(yaws) > 1.0
    centres = np.array([T[:2, 3] for T in poses])
    distances = np.linalg.norm(centres[:, None] - centres[None], axis=2) + np.eye(len(centres))
    assert distances.min() >= 0.4 + 0.0005


def test_half_turns_happen_as_often_as_requested() -> None:
    stack = tiers(catalog_object("carton_300x200x150").size, 6, (1.2, 0.8))
    poses = stack_tiers(stack, replace(FULL, half_turn_fraction=0.5), np.random.default_rng(0))
    turned = np.array([np.hypot(T[0, 0] - 1.0, T[1, 0]) > 1.0 for layer in poses for T in layer])
    base = np.array(
        [np.hypot(T[0, 0] - 1.0, T[1, 0]) > 1.0 for T in stack_tiers(stack, FULL, np.random.default_rng(0))[0]]
    )
    assert 0.3 < np.mean(turned) < 0.7
    assert base.mean() in (0.0, 1.0)


def test_jitter_that_cannot_fit_is_an_error() -> None:
    wild = replace(FULL, yaw_deg=Distribution.constant(45.0))
    with pytest.raises(PlacementError, match="lower shift_mm or yaw_deg"):
        stack_tiers(tiers(catalog_object("carton_600x400x400").size, 1, (1.2, 0.8)), wild, np.random.default_rng(0))


CARTON = catalog_object("carton_600x400x300")
DECK = (1.2, 0.8)


def layer(model, level: int, turned: bool = False):
    """Return four pieces on a EUR pallet's edges, along x or across."""
    x, y = model.size[1::-1] / 2 if turned else model.size[:2] / 2
    turn = rotation_z(np.pi / 2 if turned else 0.0)
    z = (level + 0.5) * (model.size[2] + 0.0005)
    return [(model, make_transform(turn, np.array([sx * x, sy * y, z]))) for sx in (-1, 1) for sy in (-1, 1)]


def test_a_carton_bears_what_mckees_formula_in_pounds_and_inches_leaves_of_it() -> None:
    for across in (False, True):
        assert stacking_strength(CARTON, across=across) == pytest.approx(may_carry(CARTON, across), rel=1e-3)
    # 600 x 400 mm: about 300 kg in the laboratory (32 lb/in, C flute), a good third of it in a warehouse.
    assert 110.0 < stacking_strength(CARTON) < 125.0


def test_other_goods_bear_what_their_kind_does() -> None:
    drum = catalog_object("drum_steel_216_blue")
    assert stacking_strength(drum) == pytest.approx(drum.mass * (3.0 - 0.878) / 0.878)
    assert stacking_strength(catalog_object("sack_paper_600x400x110")) == 225.0
    assert stacking_strength(catalog_object("epal1")) == np.inf


def test_a_column_leaves_what_its_lowest_carton_does_not_carry() -> None:
    column = [piece for level in range(4) for piece in layer(CARTON, level)]
    # A quarter of what stands on the block rests on each of four columns, a little more where not all of it rests.
    spare = stacking_strength(CARTON) - 3 * CARTON.mass
    assert 4 * 0.85 * spare < bearing(column, DECK) < 4 * spare


def test_layers_that_are_too_many_are_left_out_sooner_across_joints() -> None:
    straight = [piece for level in range(14) for piece in layer(CARTON, level)]
    crossed = [piece for level in range(14) for piece in layer(CARTON, level, turned=bool(level % 2))]
    for pile, across in ((straight, False), (crossed, True)):
        assert len(without_overload(pile)) == 4 * (1 + int(stacking_strength(CARTON, across=across) // CARTON.mass))


def test_a_top_supports_by_the_area_that_is_level() -> None:
    block = layer(CARTON, 0)
    assert supported_fraction(block, DECK, np.eye(4)) == pytest.approx(1.0)
    assert supported_fraction(block, DECK, make_transform(translation=np.array([0.12, 0.0, 0.0]))) == pytest.approx(0.9)
    assert supported_fraction(block[:3], DECK, np.eye(4)) == pytest.approx(0.75)
    lower = catalog_object("carton_600x400x220")
    uneven = [*block[:3], *layer(lower, 0)[3:]]
    assert supported_fraction(uneven, DECK, np.eye(4)) == pytest.approx(0.75)
    drum = catalog_object("drum_steel_216_blue")
    one = [(drum, make_transform(translation=np.array([0.0, 0.0, 0.439])))]
    assert supported_fraction(one, (0.585, 0.585), np.eye(4)) == pytest.approx(2**0.5 / 2)  # an octagon in a circle
