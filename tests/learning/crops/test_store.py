import os
import shutil
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import TrainingError
from warehouse_sim.learning.crops import CropConfig
from warehouse_sim.learning.crops.store import crops_digest, load_crops

CONFIG = CropConfig(side_px=24, depth=True, stored_points=256)


def same(a: dict[str, np.ndarray], b: dict[str, np.ndarray]) -> bool:
    return a.keys() == b.keys() and all(np.array_equal(a[name], b[name], equal_nan=True) for name in a)


def test_stored_crops_are_those_in_memory(toy_root: Path, tmp_path: Path) -> None:
    reader, progress = DatasetReader(toy_root), []
    stored = load_crops(reader, "train", CONFIG, 2, tmp_path / "deep" / "cache", progress.append)
    assert progress[-1] == 1.0
    assert same(stored, load_crops(reader, "train", CONFIG, 1, None))
    assert isinstance(stored["points"], np.memmap)
    assert len(stored["points"]) == len(stored["obj_id"]) >= 3
    progress.clear()
    assert same(stored, load_crops(reader, "train", CONFIG, 2, tmp_path / "deep" / "cache", progress.append))
    assert not progress, "read the images again"


def test_networks_share_an_entry_and_take_their_columns(toy_root: Path, tmp_path: Path) -> None:
    reader = DatasetReader(toy_root)
    load_crops(reader, "val", CONFIG, 1, tmp_path)
    colour = load_crops(reader, "val", CropConfig(side_px=24, stored_points=256), 1, tmp_path)
    shape = load_crops(reader, "val", CropConfig(side_px=24, rgb=False, depth=True, stored_points=256), 1, tmp_path)
    assert len(list(tmp_path.iterdir())) == 1
    assert "rgb" in colour
    assert not {"depth", "depth_base", "ray_map"} & colour.keys()
    assert "rgb" not in shape
    assert {"depth", "depth_base", "ray_map"} <= shape.keys()
    assert "pixel" not in load_crops(reader, "val", CropConfig(), 1, tmp_path)
    assert len(list(tmp_path.iterdir())) == 2


def test_the_digest_follows_the_data_and_the_cut(toy_root: Path, tmp_path: Path) -> None:
    copy = shutil.copytree(toy_root, tmp_path / "elsewhere")
    reader = DatasetReader(copy)
    digest = crops_digest(reader, "train", CONFIG)
    assert digest == crops_digest(DatasetReader(toy_root), "train", CONFIG)
    assert digest != crops_digest(reader, "val", CONFIG)
    assert digest != crops_digest(reader, "train", CropConfig(side_px=24, depth=True, stored_points=257))
    labels = next((copy / "bop" / "train").rglob("scene_gt.json"))
    labels.write_text(labels.read_text().replace('"obj_id": 1,', '"obj_id": 7,'))
    relabelled = crops_digest(reader, "train", CONFIG)
    assert digest != relabelled
    image = next((copy / "bop" / "train").rglob("depth/*.png"))
    image.write_bytes(image.read_bytes() + b"\0")
    assert relabelled != crops_digest(reader, "train", CONFIG)


@pytest.mark.parametrize("damage", ["points.npy", "crops.json", "missing"])
def test_a_damaged_entry_is_cut_again(toy_root: Path, tmp_path: Path, damage: str) -> None:
    reader = DatasetReader(toy_root)
    whole = {name: np.array(array) for name, array in load_crops(reader, "val", CONFIG, 1, tmp_path).items()}
    (entry,) = tmp_path.iterdir()
    if damage == "missing":
        (entry / "border_px.npy").unlink()
    else:
        (entry / damage).write_bytes((entry / damage).read_bytes()[:-10])
    assert same(whole, load_crops(reader, "val", CONFIG, 1, tmp_path))
    progress = []
    load_crops(reader, "val", CONFIG, 1, tmp_path, progress.append)
    assert not progress, "was not repaired"


class KilledError(Exception):
    pass


def test_an_interrupted_cut_leaves_no_entry(toy_root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    reader = DatasetReader(toy_root)

    def kill(share: float) -> None:
        raise KilledError

    with pytest.raises(KilledError):
        load_crops(reader, "train", CONFIG, 1, tmp_path, kill)
    assert list(tmp_path.iterdir()) == []
    # A killed process cannot clean up: what it left is deleted a day later.
    entry = tmp_path / f"train-{crops_digest(reader, 'train', CONFIG)}"
    for name, age in (("old", 2 * 24 * 3600.0), ("young", 60.0)):
        folder = tmp_path / f".{entry.name}.{name}"
        folder.mkdir()
        os.utime(folder, (time.time() - age,) * 2)
    load_crops(reader, "train", CONFIG, 1, tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {entry.name, f".{entry.name}.young"}


def test_two_at_once_end_with_one_whole_entry(toy_root: Path, tmp_path: Path) -> None:
    readers = [DatasetReader(toy_root) for _ in range(4)]
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda reader: load_crops(reader, "train", CONFIG, 1, tmp_path), readers))
    assert all(same(found[0], other) for other in found[1:])
    assert len(list(tmp_path.iterdir())) == 1


def test_a_folder_that_cannot_be_written_is_named(toy_root: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("not a folder")
    with pytest.raises(TrainingError, match="--cache none"):
        load_crops(DatasetReader(toy_root), "val", CONFIG, 1, tmp_path / "file" / "cache")
    with pytest.raises(TrainingError, match="has no split 'tests'"):
        load_crops(DatasetReader(toy_root), "tests", CONFIG, 1, None)


@pytest.mark.parametrize("cached", [False, True])
def test_nothing_to_see_gives_nothing(toy_root: Path, tmp_path: Path, cached: bool) -> None:
    config = CropConfig(min_points=10**6)
    assert load_crops(DatasetReader(toy_root), "val", config, 1, tmp_path if cached else None) is None
    assert list(tmp_path.iterdir()) == []
