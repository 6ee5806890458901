"""Run lengths of any mask are those of pycocotools."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from pycocotools import mask as coco_mask

from warehouse_sim.dataset.run_lengths import mask_of_runs, run_lengths

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
def test_masks_come_back_from_lists_and_from_what_pycocotools_packs(mask: np.ndarray) -> None:
    packed = coco_mask.encode(np.asfortranarray(mask, np.uint8))
    for counts in (run_lengths(mask)["counts"], packed["counts"].decode("ascii")):
        assert np.array_equal(mask_of_runs({"size": list(mask.shape), "counts": counts}, mask.shape, "here"), mask)
