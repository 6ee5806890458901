import numpy as np

from warehouse_sim.dataset.card.tally import BINS, split_table
from warehouse_sim.dataset.stored.observation_record import RecordedObservation, RecordedTarget


def observation(*targets: RecordedTarget) -> RecordedObservation:
    return RecordedObservation(np.eye(4), targets=targets)


def test_targets_are_counted_in_their_bins() -> None:
    near = RecordedTarget(1, 0.95, 1.5, 4000, {}, 250.0)
    far = RecordedTarget(2, 1.0, 80.0, 40, {}, None)
    table = split_table({"train": [[observation(near), observation(near, far)]], "val": [], "test": [[observation()]]})
    assert table["bins"]["distance"] == list(BINS["distance"])
    train = table["train"]
    assert (train["scenes"], train["observations"], train["targets"]) == (1, 2, 3)
    assert train["visible_fraction"] == [0] * 9 + [3]
    assert train["distance"] == [2, 0, 0, 0, 0, 0, 0, 0, 1]
    assert train["lux"] == [0, 0, 0, 0, 2, 0, 0, 0]
    assert table["val"] == {
        "scenes": 0, "observations": 0, "targets": 0,
        "visible_fraction": [0] * 10, "distance": [0] * 9, "lux": [0] * 8,
    }  # fmt: skip
    assert (table["test"]["scenes"], table["test"]["targets"]) == (1, 0)
