"""Every step of every run has a seed that torch takes."""

import pytest
import torch

from warehouse_sim.learning.order import SampleOrder
from warehouse_sim.learning.step_seed import step_seed

LARGEST = 2**63 - 1
"""Of what settings take."""


@pytest.mark.parametrize("seed", [0, 7, 2**44, LARGEST])
def test_steps_and_processes_draw_differently(seed: int) -> None:
    sampled = [
        tuple(torch.randint(2**62, (2,), generator=torch.Generator().manual_seed(step_seed(seed, step, 2, rank))))
        for step in range(20)
        for rank in range(2)
    ]
    assert len({tuple(map(int, pair)) for pair in sampled}) == 40


def test_small_seeds_are_those_of_before() -> None:
    assert [step_seed(3, 5), step_seed(3, 5, 2, 1)] == [3_000_014, 6_000_029]


def test_an_order_takes_the_largest_seed() -> None:
    first, second = (SampleOrder(50, 10, seed).indices(3).tolist() for seed in (LARGEST, LARGEST - 1))
    assert first != second
    assert set(SampleOrder(50, 50, LARGEST).indices(0).tolist()) == set(range(50))
