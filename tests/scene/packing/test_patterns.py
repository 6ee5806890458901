import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.scene.packing.pallets import least_distance, reach
from warehouse_sim.catalog import catalog_object
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.scene import Distribution
from warehouse_sim.scene.packing.mixed import pack_mixed
from warehouse_sim.scene.packing.patterns import (
    Layer,
    carried,
    grid,
    how_many,
    join,
    pattern_layers,
    possible_patterns,
)
from warehouse_sim.scene.packing.stacking import StackingConfig

EUR = (1.2, 0.8)


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


PIECE = np.array([0.4, 0.3, 0.2])


def test_a_grid_is_centred_and_spaced() -> None:
    layer = grid(PIECE, (3, 2), 0.01, turned=False)
    low, high = layer.rectangles(PIECE)
    assert len(layer) == 6
    np.testing.assert_allclose([low.min(axis=0), high.max(axis=0)], [[-0.61, -0.305], [0.61, 0.305]])
    turned = grid(PIECE, (1, 1), 0.01, turned=True, centre=(1.0, 2.0))
    np.testing.assert_allclose(turned.rectangles(PIECE), [[[0.85, 1.8]], [[1.15, 2.2]]])


def test_turning_mirroring_choosing_and_joining() -> None:
    layer = Layer(np.array([[0.1, 0.2], [0.3, -0.4]]), np.array([True, False]))
    np.testing.assert_array_equal(layer.half_turn().centres, [[-0.1, -0.2], [-0.3, 0.4]])
    np.testing.assert_array_equal(layer.mirrored().centres, [[-0.1, 0.2], [-0.3, -0.4]])
    np.testing.assert_array_equal(layer.half_turn().turned, layer.turned)
    both = join([layer, layer.subset(np.array([1]))])
    np.testing.assert_array_equal(both.turned, [True, False, False])


def test_modules_fit_in_spite_of_rounding() -> None:
    assert how_many(1.2, 0.4) == 3
    assert how_many(1.2, 0.3) == 4
    assert how_many(1.199, 0.3) == 3


@pytest.mark.parametrize(
    ("below", "fraction"),
    [
        ([(-0.5, -0.5, 0.5, 0.5)], 1.0),
        ([(-0.5, -0.5, 0.2, 0.5)], 0.7),
        ([(-0.5, -0.5, 0.0, 0.5)], 0.0),  # carried up to its centre only: it tips
        ([(-0.5, -0.5, -0.3, 0.5), (0.3, -0.5, 0.5, 0.5)], 0.4),  # a bridge
        ([(2.0, 2.0, 3.0, 3.0)], 0.0),
        ([], 0.0),
    ],
)
def test_what_is_carried(below: list[tuple[float, ...]], fraction: float) -> None:
    rows = np.array(below).reshape(-1, 4)
    low, high = np.array([[-0.5, -0.5]]), np.array([[0.5, 0.5]])
    assert carried(low, high, rows[:, :2], rows[:, 2:])[0] == pytest.approx(fraction)


HEIGHT = 1.3


def sampled_sizes(rng: np.random.Generator) -> list[np.ndarray]:
    sizes = rng.uniform([0.2, 0.15, 0.1], [0.6, 0.4, 0.4], (30, 3))
    return sorted((np.round(size, 3) for size in sizes), key=lambda size: -size[0] * size[1])


def test_every_piece_rests_on_most_of_its_base() -> None:
    for seed in range(4):
        rng = np.random.default_rng(seed)
        sizes = sampled_sizes(rng)
        exact = StackingConfig(gap_mm=1.0, shift_mm=Distribution.constant(0.0), yaw_deg=Distribution.constant(0.0))
        boxes = [OrientedBox(T, sizes[number]) for number, T in pack_mixed(sizes, (1.2, 1.0), HEIGHT, exact, rng)]
        extents = np.array([[box.corners().min(axis=0), box.corners().max(axis=0)] for box in boxes])
        for low, high in extents:
            if low[2] < 0.001:
                continue
            under = extents[np.abs(extents[:, 1, 2] + 0.0005 - low[2]) < 1e-6]
            shared = np.maximum(np.minimum(high[:2], under[:, 1, :2]) - np.maximum(low[:2], under[:, 0, :2]), 0.0)
            assert np.prod(shared, axis=1).sum() >= 0.65 * np.prod(high[:2] - low[:2]), seed


def test_pieces_are_used_once_and_what_finds_no_place_is_left_out() -> None:
    rng = np.random.default_rng(0)
    sizes = [np.array([0.6, 0.4, 0.5])] * 20
    numbers = [number for number, _ in pack_mixed(sizes, (1.2, 0.82), 1.1, StackingConfig(gap_mm=1.0), rng)]
    assert numbers == sorted(set(numbers))
    assert len(numbers) in (4, 6, 8)


# Whatever pieces and decks Hypothesis finds, nothing overlaps, leaves its surface or hangs in the air.


edges = st.integers(60, 650).map(lambda mm: mm / 1000)
pieces = st.tuples(edges, edges, edges).map(lambda e: np.array([max(e[:2]), min(e[:2]), e[2]]))
decks = st.tuples(st.integers(600, 1300), st.integers(600, 1300)).map(lambda mm: (mm[0] / 1000, mm[1] / 1000))
stacking = st.builds(
    StackingConfig,
    gap_mm=st.floats(1.0, 10.0),
    shift_mm=st.floats(0.0, 15.0).map(lambda mm: Distribution.uniform(-mm, mm)),
    yaw_deg=st.floats(0.0, 8.0).map(lambda deg: Distribution.uniform(-deg, deg)),
    half_turn_fraction=st.floats(0.0, 1.0),
)


@given(st.lists(pieces, max_size=12), decks, st.floats(0.2, 2.0), stacking, st.integers(0, 2**32))
def test_mixed_pieces_stay_apart_on_the_deck_and_below_the_height(sizes, deck, height, config, seed) -> None:
    placed = pack_mixed(sizes, deck, height, config, np.random.default_rng(seed))
    numbers = [number for number, _ in placed]
    assert numbers == sorted(set(numbers))
    if not placed:
        fits = [s[2] <= height - 0.02 and s[0] + 0.02 <= max(deck) and s[1] + 0.02 <= min(deck) for s in sizes]
        assert not any(fits)
        return
    boxes = [OrientedBox(T, sizes[number]) for number, T in placed]
    assert least_distance(boxes) >= 0.0005 - 1e-9
    assert np.all(reach(boxes) <= np.array(deck) / 2 + 1e-9)
    tops = np.concatenate([box.corners() for box in boxes])[:, 2]
    assert tops.min() >= 0.0005 - 1e-9
    assert tops.max() <= height + 1e-9


@settings(max_examples=30)
@given(pieces, decks, st.floats(0.0, 0.01))
def test_layers_of_every_possible_pattern_bear_the_next(size, deck, gap) -> None:
    for pattern in possible_patterns(size, deck, gap):
        cycle = pattern_layers(pattern, size, deck, gap)
        for upper, lower in zip((*cycle[1:], cycle[0]), cycle, strict=True):
            low, high = upper.rectangles(size)
            assert np.all(high - low > 0.0)
            spread = np.maximum(low[:, None], low) - np.minimum(high[:, None], high)  # of two rectangles, by axis
            apart = spread.max(axis=2)[~np.eye(len(low), dtype=bool)]
            assert apart.min(initial=gap) >= gap - 1e-9
            growth = gap * (np.array(deck) // min(size[:2]))
            assert np.all(np.maximum(high, -low).max(axis=0) <= np.array(deck) / 2 + growth + 1e-9)
            assert carried(low, high, *lower.rectangles(size)).min() >= 0.5
