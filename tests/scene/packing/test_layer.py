import numpy as np
import pytest

from warehouse_sim.scene.packing.layer import Layer, carried, grid, how_many, join

SIZE = np.array([0.4, 0.3, 0.2])


def test_a_grid_is_centred_and_spaced() -> None:
    layer = grid(SIZE, (3, 2), 0.01, turned=False)
    low, high = layer.rectangles(SIZE)
    assert len(layer) == 6
    np.testing.assert_allclose([low.min(axis=0), high.max(axis=0)], [[-0.61, -0.305], [0.61, 0.305]])
    turned = grid(SIZE, (1, 1), 0.01, turned=True, centre=(1.0, 2.0))
    np.testing.assert_allclose(turned.rectangles(SIZE), [[[0.85, 1.8]], [[1.15, 2.2]]])


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
