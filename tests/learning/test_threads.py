import torch

from warehouse_sim.learning.threads import cpu_threads


def test_threads_are_given_back() -> None:
    before = torch.get_num_threads()
    with cpu_threads(3):
        assert torch.get_num_threads() == 3
    assert torch.get_num_threads() == before
