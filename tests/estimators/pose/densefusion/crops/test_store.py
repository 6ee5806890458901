import json
import os
import random
import shutil
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from multiprocessing import get_context
from multiprocessing.synchronize import Barrier
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.pose.densefusion.crops.crop_set import crops_digest, load_crops
from warehouse_sim.estimators.pose.densefusion.settings import CropConfig

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

    def kill(fraction: float) -> None:
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


ROUNDS, THREADS = 50, 2
SMALL = CropConfig(stored_points=64)


def on_a_slow_disk(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return the function with random pauses around it, in which others can do what they like."""

    def paused(*args: Any, **named: Any) -> Any:
        time.sleep(random.uniform(0.0, 0.01))
        try:
            return function(*args, **named)
        finally:
            time.sleep(random.uniform(0.0, 0.01))

    return paused


def fill_together(root: Path, cache: Path, start: Barrier) -> int:
    """Load the crops of a split at the same moment as other threads and another process; return how often it failed."""
    readers, failed = [DatasetReader(root) for _ in range(THREADS)], 0
    expected = load_crops(readers[0], "val", SMALL, 1, None)
    with pytest.MonkeyPatch.context() as patch, ThreadPoolExecutor(THREADS) as pool:
        patch.setattr(Path, "rename", on_a_slow_disk(Path.rename))
        patch.setattr(shutil, "rmtree", on_a_slow_disk(shutil.rmtree))
        for folder in (cache / str(turn) for turn in range(ROUNDS)):
            start.wait(60.0)
            found = list(pool.map(lambda reader: load_crops(reader, "val", SMALL, 1, folder), readers))  # noqa: B023
            failed += any(arrays is None or not same(arrays, expected) for arrays in found)
    return failed


def fill_together_elsewhere(*arguments: Any) -> None:
    raise SystemExit(fill_together(*arguments))


def keep_busy() -> None:
    while True:
        sum(range(1000))


@pytest.mark.slow
def test_two_at_once_end_with_one_whole_entry(toy_root: Path, tmp_path: Path) -> None:
    context, name = get_context("spawn"), f"val-{crops_digest(DatasetReader(toy_root), 'val', SMALL)}"
    for turn in range(0, ROUNDS, 2):  # Damaged entries, which each must replace, are where most can go wrong.
        (tmp_path / str(turn) / name).mkdir(parents=True)
        (tmp_path / str(turn) / name / "crops.json").write_text("{")
    arguments = toy_root, tmp_path, context.Barrier(2)
    other = context.Process(target=fill_together_elsewhere, args=arguments)
    busy = [context.Process(target=keep_busy, daemon=True) for _ in range(2)]
    for process in (other, *busy):
        process.start()
    failed = fill_together(*arguments)
    other.join()
    for process in busy:
        process.kill()
    assert (failed, other.exitcode) == (0, 0)
    for turn in range(ROUNDS):
        (entry,) = (tmp_path / str(turn)).iterdir()
        contents = json.loads((entry / "crops.json").read_text())
        assert contents["bytes"] == {file.name: file.stat().st_size for file in entry.glob("*.npy")}
        assert entry.name == name


def test_a_folder_that_cannot_be_written_is_named(toy_root: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("not a folder")
    with pytest.raises(TrainingError, match="--cache none"):
        load_crops(DatasetReader(toy_root), "val", CONFIG, 1, tmp_path / "file" / "cache")
    with pytest.raises(TrainingError, match="has no split 'tests'"):
        load_crops(DatasetReader(toy_root), "tests", CONFIG, 1, None)


@pytest.mark.parametrize("cached", [False, True])
def test_nothing_to_see_gives_nothing(
    toy_root: Path, tmp_path: Path, cached: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(CropConfig, "min_points", 2**16)
    assert load_crops(DatasetReader(toy_root), "val", CropConfig(), 1, tmp_path if cached else None) is None
    assert list(tmp_path.iterdir()) == []
