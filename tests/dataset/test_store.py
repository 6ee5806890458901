import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

import pytest

from tests.dataset.toy import (
    CAMERA,
    PALLET,
    RENDERER,
    make_dataset,
    make_manifest,
    make_scene,
    observe,
    write_scene,
    write_scenes,
)
from tests.shared import hashes
from warehouse_sim.dataset.manifest import read_manifest
from warehouse_sim.dataset.store import DatasetStore
from warehouse_sim.dataset.stored.scene_record import Outcome
from warehouse_sim.errors import DatasetError, UnknownNameError

KNOWN = "known: bop, bop_compact, bop_webdataset, coco, folder, kitti, linemod, mcap, pcd, ply, yolo"


@pytest.mark.parametrize(
    "formats", [("kitti", "bop", "bop_webdataset"), ("coco", "yolo"), ("linemod",), ("mcap", "pcd", "ply")]
)
def test_neither_order_nor_day_changes_a_byte(tmp_path: Path, monkeypatch, formats: tuple[str, ...]) -> None:
    one = hashes(make_dataset(tmp_path / "one", make_manifest(formats=formats)))
    monkeypatch.setattr(time, "time_ns", lambda: 5)
    monkeypatch.setattr(time, "time", lambda: 5.0)
    assert hashes(make_dataset(tmp_path / "other", make_manifest(formats=formats), order=[2, 0, 1])) == one


def test_two_processes_give_the_same_bytes(toy_root: Path, tmp_path: Path) -> None:
    manifest = make_manifest()
    store = DatasetStore(tmp_path / "data", manifest)
    store.begin([PALLET], CAMERA)
    with ProcessPoolExecutor(1, get_context("spawn")) as other:
        job = other.submit(write_scenes, store.root, manifest, [2, 0])
        write_scenes(store.root, manifest, [1])
        job.result()
    store.finish()
    assert hashes(store.root) == hashes(toy_root)


def test_records_that_were_written_here_are_not_read_again(
    toy_root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store = DatasetStore(tmp_path / "data", make_manifest())
    store.begin([PALLET], CAMERA)
    written = [write_scene(store, index) for index in (2, 0, 1)]
    monkeypatch.delattr("warehouse_sim.dataset.store.read_scene_record")
    store.finish(written=written)
    assert hashes(store.root) == hashes(toy_root)


@pytest.mark.parametrize("formats", [("bop",), ("kitti",), ("bop", "kitti")])
def test_any_choice_of_formats_has_the_same_files(toy_root: Path, tmp_path: Path, formats: tuple[str, ...]) -> None:
    found = hashes(make_dataset(tmp_path / "data", make_manifest(formats=formats)))
    expected = {
        name: digest
        for name, digest in hashes(toy_root).items()
        if name.split("/")[0] in (*formats, "scenes", "objects.json")
    }
    del found["manifest.json"], found["SHA256SUMS"]
    found = {name: digest for name, digest in found.items() if name != "README.md" and not name.startswith("card/")}
    assert found == expected


def test_killed_run_resumes_to_the_same_bytes(toy_root: Path, tmp_path: Path) -> None:
    root = tmp_path / "data"
    store = DatasetStore(root, make_manifest())
    store.begin([PALLET], CAMERA)
    write_scene(store, 1)

    def killed() -> Iterator:
        yield observe(make_scene(0))[0]
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        store.write_scene(make_scene(0), killed(), Outcome({"problems": [], "speed": 0.0}, RENDERER))
    # What else a dying process can leave: a temporary file, and a mask that the finished scene will not have.
    (root / "bop" / "train" / "000000" / "rgb" / ".000001.png.99.part").touch()
    (root / "bop" / "train" / "000000" / "mask" / "000000_000009.png").touch()
    with pytest.raises(DatasetError, match="the dataset is incomplete; resume it with"):
        read_manifest(root)

    resumed = DatasetStore(root, make_manifest())
    resumed.begin([PALLET], CAMERA, resume=True)
    assert resumed.pending() == [0, 2]
    finished = root / "scenes" / "000001.json"
    before = finished.stat().st_mtime_ns
    for index in resumed.pending():
        write_scene(resumed, index)
    resumed.finish()
    assert finished.stat().st_mtime_ns == before
    assert hashes(root) == hashes(toy_root)


def test_resuming_a_complete_dataset_changes_nothing(toy_root: Path, tmp_path: Path) -> None:
    store = DatasetStore(make_dataset(tmp_path / "data"), make_manifest())
    store.begin([PALLET], CAMERA, resume=True)
    assert store.pending() == []
    store.finish()
    assert hashes(store.root) == hashes(toy_root)


@pytest.mark.parametrize(
    ("change", "key"),
    [
        ({"seed": 4}, "seed"),
        ({"recipe": {"description": "other"}}, "recipe"),
        ({"packages": {"numpy": "newer"}}, "packages"),
        ({"formats": ("bop",)}, "formats"),
    ],
)
@pytest.mark.parametrize("complete", [True, False])
def test_resuming_another_dataset_is_rejected(toy_copy: Path, change: dict, key: str, complete: bool) -> None:
    if not complete:
        (toy_copy / "manifest.json").rename(toy_copy / "manifest.unfinished.json")
    before = hashes(toy_copy)
    with pytest.raises(DatasetError, match=f"begun with a different value of {key}; resume it with the same settings"):
        DatasetStore(toy_copy, replace(make_manifest(), **change)).begin([PALLET], CAMERA, resume=True)
    assert hashes(toy_copy) == before


def test_other_folders_are_left_alone(tmp_path: Path) -> None:
    (tmp_path / "holiday.jpg").touch()
    with pytest.raises(DatasetError, match="the folder is not empty; choose another one, go on with --resume"):
        DatasetStore(tmp_path, make_manifest()).begin([PALLET], CAMERA)
    with pytest.raises(DatasetError, match="holds no dataset to resume; choose an empty folder"):
        DatasetStore(tmp_path, make_manifest()).begin([PALLET], CAMERA, resume=True)
    assert [path.name for path in tmp_path.iterdir()] == ["holiday.jpg"]


def test_manifest_comes_last(tmp_path: Path) -> None:
    store = DatasetStore(tmp_path / "data", make_manifest())
    store.begin([PALLET], CAMERA, resume=True)
    for index in (0, 1):
        write_scene(store, index)
    with pytest.raises(DatasetError, match=r"scenes \[2\] are missing; go on with --resume"):
        store.finish()
    assert not (store.root / "manifest.json").exists()
    write_scene(store, 2)
    finished = store.finish()
    assert replace(finished, checksums="") == replace(
        make_manifest(), renderers=(RENDERER,), split_table=finished.split_table
    )
    assert finished.split_table["train"]["observations"] == 2
    assert read_manifest(store.root) == finished
    assert not (store.root / "manifest.unfinished.json").exists()


@pytest.mark.parametrize(
    ("observations", "message"),
    [
        (lambda first, second: [first], "scene 0: 1 observations, the dataset has 2 in every scene"),
        (lambda first, second: [second, first], "observation 1 of scene 0 came as number 0 of 2"),
        (lambda first, second: [first, second, first], "observation 0 of scene 0 came as number 2 of 2"),
        (lambda first, second: [first, replace(second, scene_index=1)], "observation 1 of scene 1 came as number 1"),
    ],
)
def test_scene_with_wrong_observations_stays_pending(tmp_path: Path, observations, message: str) -> None:
    store = DatasetStore(tmp_path / "data", make_manifest())
    store.begin([PALLET], CAMERA)
    with pytest.raises(DatasetError, match=message):
        store.write_scene(make_scene(0), observations(*observe(make_scene(0))), Outcome({}, RENDERER))
    assert store.pending() == [0, 1, 2]


def test_unknown_format_lists_the_known_ones(tmp_path: Path) -> None:
    with pytest.raises(
        UnknownNameError,
        match=f"unknown dataset format 'cacao'; {KNOWN}",
    ):
        DatasetStore(tmp_path, make_manifest(formats=("bop", "cacao")))
