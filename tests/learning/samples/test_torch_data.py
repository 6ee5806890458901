"""Any iterable feeds torch's loaders, in this process and in several."""

from itertools import count

import torch
from torch.utils.data import DataLoader

from warehouse_sim.learning.samples.torch_data import IterableData


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
