import numpy as np

from warehouse_sim.learning.samples.order import GroupedOrder


def test_a_step_is_of_one_group_and_each_sample_comes_about_equally_often() -> None:
    order = GroupedOrder([30, 90, 15], 5, 1)
    counts, starts = np.zeros(135), np.array([0, 30, 120])
    for step in range(2700):
        index = order.indices(step)
        group, rows = order.group_of(index)
        np.testing.assert_array_equal(rows.numpy() + starts[group], index.numpy())
        assert rows.max() < [30, 90, 15][group]
        np.add.at(counts, index.numpy(), 1)
    assert counts.min() > 85
    assert counts.max() < 115


def test_a_step_does_not_depend_on_those_before() -> None:
    a, b = GroupedOrder([10, 20], 4, 3), GroupedOrder([10, 20], 4, 3)
    rows = [a.indices(step).tolist() for step in range(50)]
    assert b.indices(49).tolist() == rows[49]
