import threading
from collections import Counter
from itertools import count
from pathlib import Path

import numpy as np
import pytest
import torch
from torch.utils.data import DataLoader

from warehouse_sim.learning.loop import MadeAhead
from warehouse_sim.learning.samples.array_store import GrowingArray, map_array, shared_tensor
from warehouse_sim.learning.samples.joined import JoinedRows, joined_alike
from warehouse_sim.learning.samples.order import SampleOrder, step_seed
from warehouse_sim.learning.samples.torch_data import IterableData


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


@pytest.mark.parametrize("workers", [1, 4])
def test_what_is_requested_for_comes_in_order_whatever_was_guessed(workers: int) -> None:
    made, lock = Counter[tuple[int, bool]](), threading.Lock()

    def make(key: tuple[int, bool]) -> str:
        with lock:
            made[key] += 1
        return f"{key}"

    ahead = MadeAhead(make, workers)
    for step in range(0, 60, 3):
        right = step % 2 == 0
        keys = [(number, step >= 30) for number in range(step, step + 3)]
        following = [(number, step >= 30 or not right) for number in range(step + 3, step + 6)]
        assert ahead.take(keys, following) == [f"{key}" for key in keys]
    assert max(made.values()) == 1


def test_a_thread_that_fails_is_heard_of() -> None:
    def make(key: int) -> int:
        return 1 // key

    ahead = MadeAhead(make, 2)
    assert ahead.take([1], [0]) == [1]
    with pytest.raises(ZeroDivisionError):
        ahead.take([0])


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


# Any iterable feeds torch's loaders, in this process and in several.


def doubled(number: int) -> torch.Tensor:
    return torch.tensor(2 * number)


def test_samples_come_in_order_and_no_more_are_made_than_are_taken() -> None:
    taken = []

    def numbers():
        for number in count():
            taken.append(number)
            yield number

    batches = iter(DataLoader(IterableData(numbers(), doubled), batch_size=3))
    assert [next(batches).tolist() for _ in range(2)] == [[0, 2, 4], [6, 8, 10]]
    assert taken == list(range(6))


def test_workers_of_a_loader_share_the_items_out() -> None:
    loader = DataLoader(IterableData(range(7), doubled), batch_size=None, num_workers=2)
    assert sorted(int(item) for item in loader) == [0, 2, 4, 6, 8, 10, 12]
