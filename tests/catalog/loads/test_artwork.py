import numpy as np
import pytest

from warehouse_sim.catalog.loads.artwork import (
    barcode,
    handling_mark,
    moved,
    on_side,
    rectangle,
    text_lines,
    word,
    word_width,
)

SIZE = (0.6, 0.4, 0.3)


def extent(shapes: tuple) -> np.ndarray:
    points = np.concatenate([np.array(shape) for shape in shapes])
    return np.array([points.min(axis=0), points.max(axis=0)])


def test_a_barcode_fills_its_width_with_bars_of_whole_modules() -> None:
    bars = barcode(7, 0.1, 0.03)
    np.testing.assert_allclose(extent(bars), [[-0.05, -0.015], [0.05, 0.015]])
    widths = np.array([bar[1][0] - bar[0][0] for bar in bars])
    module = widths.min()
    assert len(bars) == 18
    np.testing.assert_allclose(widths / module, np.round(widths / module))
    assert widths.max() / module <= 3.0 + 1e-9
    assert barcode(7, 0.1, 0.03) == bars
    assert barcode(8, 0.1, 0.03) != bars


def test_words_lines_and_marks_have_the_size_requested_for() -> None:
    assert word_width("ALTO", 0.06) == pytest.approx(0.19)
    np.testing.assert_allclose(np.ptp(extent(word("ALTO", 0.06)), axis=0), [0.19, 0.06])
    np.testing.assert_allclose(extent(text_lines(0.1, 0.04, (0.5, 1.0)))[1], [0.05, 0.02])
    for mark in ("up", "fragile", "dry"):
        low, high = extent(handling_mark(mark, 0.1))
        assert 0.1 <= high[1] - low[1] <= 0.107
        assert high[0] - low[0] < 0.1


@pytest.mark.parametrize(
    ("side", "axis", "right"), [("+y", 1, (0, -1)), ("-y", 1, (0, 1)), ("+x", 0, (1, 1)), ("-x", 0, (1, -1))]
)
def test_print_reads_from_outside(side: str, axis: int, right: tuple[int, int]) -> None:
    shape = moved((rectangle(0.0, 0.0, 0.04, 0.02),), 0.05, 0.01)
    (part,) = on_side(shape, side, SIZE, "print_dark", 0.001, 0.002)
    vertices = part.placed().vertices
    outer = np.abs(vertices[:, axis]).max()
    assert outer == pytest.approx(SIZE[axis] / 2 - 0.001)
    along, sign = right
    np.testing.assert_allclose([np.min(sign * vertices[:, along]), np.max(sign * vertices[:, along])], [0.05, 0.09])
    np.testing.assert_allclose([vertices[:, 2].min(), vertices[:, 2].max()], [0.01, 0.03])
