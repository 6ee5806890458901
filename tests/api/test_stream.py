"""``ws.stream`` feeds torch's loaders and a plain loop with the observations of the dataset of that seed."""

import os
from itertools import islice
from typing import Any

import numpy as np
import pytest
from torch.utils.data import DataLoader, IterableDataset

import warehouse_sim as ws
from tests.processes import scene_workers
from tests.shared import Shared
from warehouse_sim.errors import WarehouseSimError

pytestmark = pytest.mark.gl


def depth(obs: ws.Observation) -> np.ndarray:
    return np.asarray(obs.depth)


def test_a_loop_and_a_loader_take_what_files_hold_and_leave_no_maker(shared: Shared) -> None:
    files = [depth(obs) for obs in ws.Dataset(shared.dataset(shared.bare, scenes=3, formats=("bop",)))]
    endless = ws.stream(shared.bare, depth, seed=0, start=1, outputs=["depth", "poses"])
    assert isinstance(endless, IterableDataset)
    taken = list(islice(endless, 2))
    assert sorted(image.tobytes() for image in taken) == sorted(image.tobytes() for image in files[1:])
    batches: Any = iter(DataLoader(endless, batch_size=2))
    np.testing.assert_array_equal(next(batches).numpy(), np.stack(taken))  # each loop begins with the same one
    del batches
    assert scene_workers(os.getpid()) == []


@pytest.mark.parametrize(
    ("recipe", "settings", "words"),
    [
        ("smokee", {}, "did you mean 'smoke'"),
        ("smoke", {"workers": 0}, "workers must be 1-256"),
        ("smoke", {"start": -1}, "start must be 0-"),
        ("smoke", {"scenes": 0}, "scenes must be 1-1,000,000"),
        ("smoke", {"seed": 0.5}, "seed must be"),
        ("smoke", {"outputs": ["rgbb", "poses"]}, "did you mean 'rgb'"),
        ("smoke", {"sampel": depth}, "sampel"),
    ],
)
def test_what_cannot_be_streamed_is_said_at_once(recipe: str, settings: dict[str, Any], words: str) -> None:
    with pytest.raises(WarehouseSimError) as caught:
        ws.stream(recipe, **settings)
    assert words in str(caught.value)
