import numpy as np
import pytest

from warehouse_sim.geometry import mesh as module
from warehouse_sim.geometry.mesh import equal_rows


@pytest.mark.parametrize("collide", [False, True], ids=["hashed", "all hashes equal"])
@pytest.mark.parametrize("count", [0, 1, 2, 5000])
def test_rows_are_grouped_as_numpy_groups_them(count: int, collide: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    if collide:
        monkeypatch.setattr(module, "_FACTORS", np.zeros(64, np.uint64))
    rows = np.random.default_rng(count).integers(-3, 4, (count, 3)).astype(float)
    one, group = equal_rows(rows)
    assert (rows[one][group] == rows).all()
    assert len(one) == len(np.unique(rows, axis=0))
    assert sorted(group[one]) == list(range(len(one)))


def test_rows_that_differ_in_one_bit_are_told_apart() -> None:
    rows = np.zeros((1 + 96, 12), np.uint8)
    for bit in range(96):
        rows[1 + bit, bit // 8] = 1 << bit % 8
    assert len(equal_rows(rows)[0]) == len(rows)
