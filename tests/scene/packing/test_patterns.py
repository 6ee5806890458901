import numpy as np
import pytest

from warehouse_sim.catalog import catalog_object
from warehouse_sim.scene.packing.patterns import (
    Layer,
    carried,
    grid,
    how_many,
    join,
    pattern_layers,
    possible_patterns,
)

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
