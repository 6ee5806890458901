from pathlib import Path

import numpy as np
import pytest
import torch

from warehouse_sim.learning.samples.array_store import GrowingArray, map_array, shared_tensor


def test_grown_array_is_an_ordinary_npy_file(tmp_path: Path) -> None:
    whole = np.arange(2345 * 6, dtype=np.int16).reshape(2345, 2, 3)
    file = GrowingArray(tmp_path / "a.npy", (2, 3), np.dtype(np.int16))
    for start in range(0, 2345, 100):
        file.append(whole[start : start + 100])
    file.close()
    np.testing.assert_array_equal(np.load(tmp_path / "a.npy"), whole)
    mapped = map_array(tmp_path / "a.npy")
    assert isinstance(mapped, np.memmap)
    assert torch.equal(shared_tensor(mapped), torch.from_numpy(whole))


def test_rows_of_another_kind_are_rejected(tmp_path: Path) -> None:
    file = GrowingArray(tmp_path / "a.npy", (4,), np.dtype(np.float32))
    with pytest.raises(ValueError, match="float32"):
        file.append(np.zeros((3, 4)))
    with pytest.raises(ValueError, match=r"\(4,\)"):
        file.append(np.zeros((3, 5), dtype=np.float32))
