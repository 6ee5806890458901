"""Run lengths of any mask are those of pycocotools."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from pycocotools import mask as coco_mask

from warehouse_sim.dataset.files.run_lengths import compressed, mask_of_runs, run_lengths
from warehouse_sim.errors import DatasetError

masks = arrays(bool, array_shapes(min_dims=2, max_dims=2, max_side=24), elements=st.booleans(), fill=st.booleans())


@given(masks)
def test_pycocotools_encodes_the_same_runs_and_decodes_the_mask(mask: np.ndarray) -> None:
    runs = run_lengths(mask)
    assert runs["size"] == list(mask.shape)
    assert sum(runs["counts"]) == mask.size
    assert all(count > 0 for count in runs["counts"][1:])
    compressed = coco_mask.frPyObjects(runs, *mask.shape)
    np.testing.assert_array_equal(coco_mask.decode(compressed), mask)
    assert coco_mask.area(compressed) == mask.sum()
    assert compressed["counts"] == coco_mask.encode(np.asfortranarray(mask.astype(np.uint8)))["counts"]


@given(masks)
def test_runs_are_read_as_pycocotools_writes_them(mask: np.ndarray) -> None:
    encoded = coco_mask.encode(np.asfortranarray(mask.astype(np.uint8)))
    runs = {"size": list(mask.shape), "counts": encoded["counts"].decode("ascii")}
    assert compressed(run_lengths(mask)) == runs
    np.testing.assert_array_equal(mask_of_runs(runs, mask.shape, "here"), mask)
    np.testing.assert_array_equal(mask_of_runs(run_lengths(mask), mask.shape, "here"), mask)


@pytest.mark.parametrize(
    ("runs", "says"),
    [
        ({"size": [3, 4], "counts": [12]}, r"has the size \[3, 4\], its image \[2, 4\]"),
        ({"size": [2, 4], "counts": [9]}, "fill 9 of 8 pixels"),
        ({"size": [2, 4], "counts": [10, -2]}, "must be whole numbers >= 0"),
        ({"size": [2, 4], "counts": "o"}, "end within a number"),
        ({"size": [2, 4], "counts": "é"}, "hold 'é' where"),
        ({"size": [2, 4], "counts": "oooooooooo1"}, "hold 'o' where"),
        ({"size": [2, 4], "counts": "`00000"}, "end within a number|fill|must be"),
        ([[1, 2]], "has the size None"),
    ],
)
def test_runs_of_no_mask_are_rejected(runs: object, says: str) -> None:
    with pytest.raises(DatasetError, match=says):
        mask_of_runs(runs, (2, 4), "here")
