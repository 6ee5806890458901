import numpy as np
import pytest

from warehouse_sim.learning.samples.joined import JoinedRows, joined_alike


def test_rows_are_those_of_the_parts_end_to_end() -> None:
    rng = np.random.default_rng(0)
    parts = [rng.random((count, 2, 3)) for count in (3, 1, 4)]
    joined, whole = JoinedRows(parts), np.concatenate(parts)
    assert joined.shape == whole.shape
    for row in range(len(whole)):
        np.testing.assert_array_equal(joined[row], whole[row])
    for row in (-1, 8):
        with pytest.raises(IndexError, match=f"row {row} of 8"):
            joined[row]


def test_rows_of_another_kind_are_not_joined() -> None:
    with pytest.raises(ValueError, match="one shape and type"):
        JoinedRows([np.zeros((2, 3)), np.zeros((2, 4))])
    a, b, c = ({"x": np.full((2, width), width), "y": np.zeros(2)} for width in (3, 4, 3))
    wide, narrow = joined_alike([b, a, c], ("y",))
    assert wide is b
    assert narrow["x"].shape == (4, 3)
    assert isinstance(narrow["y"], np.ndarray)
