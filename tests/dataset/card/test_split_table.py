from pathlib import Path

import numpy as np

from warehouse_sim.dataset.card.tally import BINS, Tally, count_in_bins, split_table
from warehouse_sim.dataset.manifest import read_manifest
from warehouse_sim.dataset.stored.scene_record import read_scene_record


def test_what_lies_beyond_the_bins_counts_in_the_outer_ones() -> None:
    assert count_in_bins([1.5, 1.5, 80.0], "distance") == [2, 0, 0, 0, 0, 0, 0, 0, 1]
    assert count_in_bins([0.95, 0.95, 1.0], "visible_fraction") == [0] * 9 + [3]
    assert count_in_bins([250.0, 250.0], "lux") == [0, 0, 0, 0, 2, 0, 0, 0]


def test_the_table_counts_what_scene_records_say(toy_root: Path) -> None:
    manifest = read_manifest(toy_root)
    assert manifest.split_table["bins"]["distance"] == list(BINS["distance"])
    for split, scenes in manifest.splits.items():
        seen = [item for index in scenes for item in read_scene_record(toy_root, index).observations]
        targets = [target for item in seen for target in item.targets]
        row = manifest.split_table[split]
        assert (row["scenes"], row["observations"], row["targets"]) == (len(scenes), len(seen), len(targets))
        for name in ("distance", "visible_fraction"):
            counts, _ = np.histogram([getattr(item, name) for item in targets], BINS[name])
            assert row[name] == counts.tolist()
        assert sum(row["distance"]) == len(targets)
    assert sum(manifest.split_table[split]["targets"] for split in manifest.splits) > 3


def test_a_split_without_scenes_has_zeros() -> None:
    assert split_table({"val": Tally()})["val"] == {
        "scenes": 0, "observations": 0, "targets": 0,
        "visible_fraction": [0] * 10, "distance": [0] * 9, "lux": [0] * 8,
    }  # fmt: skip
