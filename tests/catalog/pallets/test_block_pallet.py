from collections import Counter

import numpy as np
import pytest

from warehouse_sim.catalog.pallets import pallet, plans
from warehouse_sim.catalog.pallets.block_pallet import build
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.separation import BoxStack

PALLET = pallet("epal1")
PARTS = BoxStack.of([OrientedBox(part.T_object_part, part.scale) for part in PALLET.parts])


def millimetres(values: np.ndarray) -> tuple[float, ...]:
    return tuple(round(float(1000 * value), 6) for value in values)


def test_eleven_boards_and_nine_blocks_have_the_published_sizes() -> None:
    sizes = Counter(millimetres(part.scale) for part in PALLET.parts)
    assert sizes == {
        (1200, 145, 22): 4,  # three in the deck, one below
        (1200, 100, 22): 4,  # two in the deck, two below
        (145, 800, 22): 3,
        (145, 100, 78): 6,
        (145, 145, 78): 3,
    }


def test_deck_boards_lie_in_order_with_gaps_of_41_25_mm() -> None:
    deck = sorted((p for p in PALLET.parts if p.T_object_part[2, 3] > 0.06), key=lambda p: p.T_object_part[1, 3])
    assert [round(1000 * p.scale[1]) for p in deck] == [145, 100, 145, 100, 145]
    edges = np.array([(p.T_object_part[1, 3] - p.scale[1] / 2, p.T_object_part[1, 3] + p.scale[1] / 2) for p in deck])
    np.testing.assert_allclose(edges[1:, 0] - edges[:-1, 1], 0.04125, atol=1e-12)


@pytest.mark.parametrize("plan", [plans.EPAL1, plans.EPAL2, plans.EPAL3, plans.EPAL6, plans.EPAL7, plans.BLUE_BLOCK])
def test_pieces_touch_and_none_is_inside_another(plan: plans.BlockPallet) -> None:
    parts = build(plan, "made", "pallet_wood", "pallet_block").parts
    stack = BoxStack.of([OrientedBox(part.T_object_part, part.scale) for part in parts])
    pairs = np.array([(a, b) for a in range(len(parts)) for b in range(a)])
    distance = stack.separation(stack, pairs).distance
    assert distance.min() > -1e-9
    assert set(pairs[distance < 1e-9].ravel()) == set(range(len(parts)))


@pytest.mark.parametrize(("plan", "published"), [(plans.EPAL1, 25.0), (plans.EPAL2, 35.0), (plans.EPAL3, 30.0)])
def test_the_wood_weighs_about_what_is_published(plan: plans.BlockPallet, published: float) -> None:
    volume = sum(np.prod(part.scale) for part in build(plan, "made", "pallet_wood", "pallet_block").parts)
    assert 553.0 * volume == pytest.approx(published, rel=0.06)


def test_the_base_frame_is_closed_around_the_pallet() -> None:
    parts = build(plans.EPAL2, "made", "pallet_wood", "pallet_block").parts
    base = [part for part in parts if part.T_object_part[2, 3] - part.scale[2] / 2 < -0.081 + 1e-9]
    assert Counter(millimetres(part.scale[:2]) for part in base) == {(145, 1000): 2, (910, 100): 2, (910, 145): 1}


def test_steel_brackets_stand_flush_in_the_long_sides() -> None:
    for plan in (plans.EPAL6, plans.EPAL7):
        steel = [part for part in build(plan, "made", "wood", "block").parts if part.material == "galvanised"]
        plates = [part for part in steel if part.scale[0] > 0.05]
        assert (len(steel), len(plates)) == (18, 6)
        assert {round(abs(p.T_object_part[1, 3]) + p.scale[1] / 2, 9) for p in plates} == {0.3}
        assert min(part.scale.min() for part in steel) == pytest.approx(0.003)
