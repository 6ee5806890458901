import itertools

import numpy as np
import pytest

from tests.scene.packing.pallets import DECKS, least_distance
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.loads.cartons import SKUS
from warehouse_sim.catalog.loads.sacks import SACKS
from warehouse_sim.catalog.loads.totes import TOTES
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.scene.packing.layer import Layer, carried
from warehouse_sim.scene.packing.patterns import PATTERNS, pattern_layers, possible_patterns

EUR = (1.2, 0.8)


def boxes(layer: Layer, size: np.ndarray) -> list[OrientedBox]:
    low, high = layer.rectangles(size)
    return [
        OrientedBox(make_transform(translation=np.array([*(a + b) / 2, 0.0])), np.array([*(b - a), size[2]]))
        for a, b in zip(low, high, strict=True)
    ]


def sizes(seed: int) -> list[np.ndarray]:
    rng = np.random.default_rng(seed)
    free = np.round(rng.uniform([0.15, 0.12, 0.1], [0.62, 0.5, 0.5], (12, 3)), 3)
    return [np.array([*np.sort(size[:2])[::-1], size[2]]) for size in free]


def test_no_pattern_overlaps_or_leaves_the_deck_for_any_size() -> None:
    for deck, pattern in itertools.product(DECKS, PATTERNS):
        known = [catalog_object(name).size for name in (*SKUS, *TOTES, *SACKS)]
        for size in [*known, *(size for seed in range(2) for size in sizes(seed))]:
            for gap in (0.0, 0.004):
                for layer in pattern_layers(pattern, size, deck, gap):
                    low, high = layer.rectangles(size)
                    assert least_distance(boxes(layer, size)) >= gap - 1e-9, (deck, pattern)
                    growth = gap * (np.array(deck) // min(size[:2]))
                    assert np.all(high.max(axis=0) <= np.array(deck) / 2 + growth + 1e-9), (deck, pattern)
                    assert np.all(low.min(axis=0) >= -np.array(deck) / 2 - growth - 1e-9), (deck, pattern)


def test_every_piece_is_carried_by_the_layer_below() -> None:
    for deck, name in itertools.product(DECKS, SKUS):
        size = catalog_object(name).size
        for pattern in possible_patterns(size, deck, 0.003):
            cycle = pattern_layers(pattern, size, deck, 0.003)
            for upper, lower in zip((*cycle[1:], cycle[0]), cycle, strict=True):
                assert carried(*upper.rectangles(size), *lower.rectangles(size)).min() >= 0.5, (deck, name)


@pytest.mark.parametrize(("sku", "count"), [("600x400x400", 4), ("400x300x200", 8), ("300x200x200", 16)])
def test_columns_of_modular_cartons_fill_the_pallet(sku: str, count: int) -> None:
    size = catalog_object(f"carton_{sku}").size
    (layer,) = pattern_layers("column", size, EUR, 0.0)
    low, high = layer.rectangles(size)
    assert len(layer) == count
    np.testing.assert_allclose([low.min(axis=0), high.max(axis=0)], [[-0.6, -0.4], [0.6, 0.4]], atol=1e-12)


def test_five_of_600_x_400_interlock_on_1200_x_1000() -> None:
    lower, upper = pattern_layers("interlock", catalog_object("carton_600x400x300").size, (1.2, 1.0), 0.0)
    assert len(lower) == len(upper) == 5
    assert sorted(lower.turned) == [False, False, True, True, True]
    np.testing.assert_array_equal(upper.centres, -lower.centres)


def test_interlocked_joints_are_covered() -> None:
    size = catalog_object("carton_400x300x250").size
    lower, upper = pattern_layers("interlock", size, EUR, 0.0)
    below = {tuple(np.round(row, 6)) for row in lower.centres}
    assert len(below & {tuple(np.round(row, 6)) for row in upper.centres}) < len(upper) / 2


def test_a_pinwheel_turns_around_a_chimney() -> None:
    size = np.array([0.6, 0.4, 0.3])
    layer, above = pattern_layers("pinwheel", size, (1.0, 1.0), 0.0)
    assert sorted(layer.turned) == [False, False, True, True]
    low, high = layer.rectangles(size)
    inside = np.all((low < 0.0) & (high > 0.0), axis=1)
    assert not inside.any()  # the middle is free
    quarter = np.column_stack([-layer.centres[:, 1], layer.centres[:, 0]])
    assert {tuple(np.round(row, 9)) for row in quarter} == {tuple(np.round(row, 9)) for row in layer.centres}
    np.testing.assert_array_equal(above.centres[:, 0], -layer.centres[:, 0])


def test_a_split_row_is_flush_with_the_edges_and_void_inside() -> None:
    size = catalog_object("carton_400x300x250").size
    layer, _ = pattern_layers("split_row", size, EUR, 0.0)
    low, high = layer.rectangles(size)
    np.testing.assert_allclose([low.min(axis=0), high.max(axis=0)], [[-0.6, -0.4], [0.6, 0.4]], atol=1e-9)
    assert len(set(layer.turned)) == 2
    assert len(layer) * 0.12 < 0.96


def test_square_pieces_that_would_stand_in_columns_have_no_other_pattern() -> None:
    assert possible_patterns(np.array([0.4, 0.4, 0.3]), EUR, 0.003) == ("column",)


def test_what_does_not_fit_has_no_pattern() -> None:
    assert pattern_layers("column", np.array([1.3, 0.9, 0.2]), EUR, 0.0) == ()
    assert possible_patterns(np.array([1.2, 0.8, 0.2]), EUR, 0.0) == ("column",)
