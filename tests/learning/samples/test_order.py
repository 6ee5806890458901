from collections import Counter

import pytest
import torch

from warehouse_sim.learning.samples.order import SampleOrder, step_seed


def stream(first: int, last: int, samples: int = 10, batch: int = 4) -> list[torch.Tensor]:
    order = SampleOrder(samples, batch, 3)
    return [order.indices(step) for step in range(first, last)]


def test_every_pass_holds_every_sample_once() -> None:
    flat = [index for batch in stream(0, 15) for index in batch.tolist()]
    assert len(flat) == 60
    for start in range(0, 60, 10):
        assert Counter(flat[start : start + 10]) == Counter(range(10))
    assert flat[:10] != flat[10:20]


def test_a_resumed_stream_goes_on_where_the_first_stopped() -> None:
    whole = [batch.tolist() for batch in stream(0, 12)]
    parts = [batch.tolist() for first, last in ((0, 5), (5, 12)) for batch in stream(first, last)]
    assert parts == whole


def test_a_batch_may_be_larger_than_the_data() -> None:
    (batch,) = stream(0, 1, samples=3, batch=7)
    counts = Counter(batch.tolist())
    assert sorted(counts) == [0, 1, 2]
    assert max(counts.values()) == 3


def test_weights_say_how_often_a_sample_comes() -> None:
    weights = torch.tensor([0.25] * 4 + [1.0] * 3 + [3.0] * 2)
    weights = weights / weights.mean()
    order = SampleOrder(9, 9, 3, weights)
    flat = [index for step in range(400) for index in order.indices(step)]
    times = torch.bincount(torch.stack(flat), minlength=9) / 400
    torch.testing.assert_close(times, weights, atol=0.06, rtol=0)
    # Every pass holds each as often as its weight says, rounded up or down.
    for start in range(0, 9 * 50, 9):
        count = torch.bincount(torch.stack(flat[start : start + 9]), minlength=9)
        assert ((count >= weights.floor()) & (count <= weights.ceil())).all()


def test_equal_weights_draw_every_sample_once_a_pass() -> None:
    order = SampleOrder(10, 4, 3, torch.ones(10))
    flat = [index for step in range(15) for index in order.indices(step).tolist()]
    for start in range(0, 60, 10):
        assert Counter(flat[start : start + 10]) == Counter(range(10))


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
