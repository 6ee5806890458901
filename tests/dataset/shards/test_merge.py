"""Shards put together are the dataset of one run, to the byte; what does not fit together is rejected."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from tests.dataset.toy import CAMERA, PALLET, make_dataset, make_manifest, write_scene
from tests.shared import hashes
from warehouse_sim.cli.main import main
from warehouse_sim.dataset.manifest import Manifest, read_manifest
from warehouse_sim.dataset.shards.merge import merge
from warehouse_sim.dataset.shards.shard import Shard, parse_shard
from warehouse_sim.dataset.store import DatasetStore
from warehouse_sim.errors import DatasetError, InputError

FORMATS = ("kitti", "bop", "bop_webdataset", "bop_compact", "coco", "linemod", "yolo", "pcd", "mcap")


def make_shard(root: Path, index: int, count: int, manifest: Manifest | None = None) -> Path:
    store, shard = DatasetStore(root, manifest or make_manifest()), Shard(index, count)
    store.begin([PALLET], CAMERA, shard=shard)
    for scene in shard.scenes(store.manifest.scenes):
        write_scene(store, scene)
    return root


@pytest.fixture(scope="module")
def shards(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """All shards of a toy dataset, to read only."""
    folder = tmp_path_factory.mktemp("shards")
    return [make_shard(folder / str(index), index, 2) for index in range(2)]


def test_shards_in_any_order_are_the_bytes_of_one_run_in_every_format(tmp_path: Path) -> None:
    manifest = make_manifest(5, FORMATS)
    one = make_dataset(tmp_path / "one", manifest)
    parts = [make_shard(tmp_path / str(index), index, 3, manifest) for index in (2, 0, 1)]
    before = [hashes(part) for part in parts]
    assert main(["generate", "--merge", *map(str, parts), "--out", str(tmp_path / "merged")]) == 0
    assert hashes(tmp_path / "merged") == hashes(one)
    assert [hashes(part) for part in parts] == before


def test_more_shards_than_scenes_leave_some_empty(tmp_path: Path) -> None:
    parts = [make_shard(tmp_path / str(index), index, 4) for index in range(4)]
    merge(parts, tmp_path / "merged")
    assert hashes(tmp_path / "merged") == hashes(make_dataset(tmp_path / "one"))


def test_an_interrupted_merge_goes_on(shards: list[Path], tmp_path: Path, toy_root: Path) -> None:
    class StoppedError(Exception):
        pass

    def stop(done: int, total: int) -> None:
        if done == 1:
            raise StoppedError

    with pytest.raises(StoppedError):
        merge(shards, tmp_path, progress=stop)
    with pytest.raises(DatasetError, match="incomplete"):
        read_manifest(tmp_path)
    with pytest.raises(DatasetError, match="not empty"):
        merge(shards, tmp_path)
    merge(shards, tmp_path, resume=True)
    assert hashes(tmp_path) == hashes(toy_root)


def test_missing_repeated_and_other_shards_are_named(shards: list[Path], tmp_path: Path, toy_root: Path) -> None:
    out, other = tmp_path / "out", make_shard(tmp_path / "seed", 1, 2, replace(make_manifest(), seed=4))
    third = make_shard(tmp_path / "third", 1, 3)
    paired_variant = Path(shutil.copytree(shards[0], tmp_path / "paired_variant"))
    for parts, words in (
        ([shards[0]], "shards 1/2 are missing"),
        ([shards[0], paired_variant], "paired_variant: is shard 0/2, and so is .*; name each shard once"),
        ([shards[0], other], "seed: was made with a different value of seed than"),
        ([shards[0], third], "third: is shard 1/3, .* is shard 0/2"),
        ([shards[0], toy_root], r"is no shard, it has no shard\.json"),
        ([shards[0], tmp_path / "nothing"], r"is no shard"),
        ([], "name the folders"),
    ):
        with pytest.raises(DatasetError, match=words):
            merge(parts, out)
        assert not out.exists()
    with pytest.raises(DatasetError, match="lies in the shard"):
        merge(shards, shards[0] / "out")


def test_a_shard_that_is_not_whole_or_was_changed_is_rejected(shards: list[Path], tmp_path: Path) -> None:
    lacking = Path(shutil.copytree(shards[0], tmp_path / "lacking"))
    (lacking / "scenes/000002.json").unlink()
    with pytest.raises(DatasetError, match=r"shard 0/2 lacks the scenes 2; go on with .* --shard 0/2 --resume"):
        merge([lacking, shards[1]], tmp_path / "out")
    changed = Path(shutil.copytree(shards[0], tmp_path / "changed"))
    (changed / "objects.json").write_text("[]")
    with pytest.raises(DatasetError, match=r"objects\.json: is not the file that another shard has"):
        merge([shards[1], changed], tmp_path / "out")
    (changed / "objects.json").unlink()
    (changed / "objects.json").symlink_to("/etc/hostname")
    with pytest.raises(DatasetError, match=r"objects\.json: is a link"):
        merge([changed, shards[1]], tmp_path / "out2")
    (changed / "objects.json").unlink()
    shutil.copyfile(shards[0] / "objects.json", changed / "objects.json")
    (changed / "elsewhere").symlink_to("/etc", target_is_directory=True)
    with pytest.raises(DatasetError, match=r"elsewhere: is a link"):
        merge([changed, shards[1]], tmp_path / "out4")
    (changed / "shard.json").write_text(json.dumps({"index": 2, "count": 2}))
    with pytest.raises(DatasetError, match=r"shard\.json: .*of 2 shards there is no 2"):
        merge([changed, shards[1]], tmp_path / "out3")


def test_a_shard_is_no_dataset_and_goes_on_only_as_itself(shards: list[Path]) -> None:
    with pytest.raises(
        DatasetError, match="this is one shard of a dataset, which is incomplete; put all of them together with"
    ):
        read_manifest(shards[0])
    for shard, words in ((None, "holds shard 0/2, the whole dataset is requested"), (Shard(1, 2), "shard 1/2 is")):
        with pytest.raises(DatasetError, match=words):
            DatasetStore(shards[0], make_manifest()).begin([PALLET], CAMERA, True, shard)
    DatasetStore(shards[0], make_manifest()).begin([PALLET], CAMERA, True, Shard(0, 2))


@pytest.mark.parametrize("text", ["", "1", "1/", "2/2", "-1/2", "0/0", "1/2/3", "a/b", "0/9999999", "٠/٢"])
def test_what_names_no_shard_is_one_line(text: str) -> None:
    with pytest.raises(InputError, match="--shard"):
        parse_shard(text)


def test_scenes_that_shards_lack_are_done_without_on_request(tmp_path: Path) -> None:
    parts = [make_shard(tmp_path / str(index), index, 2) for index in range(2)]
    (parts[1] / "scenes/000001.json").unlink()
    with pytest.raises(DatasetError, match=r"lacks the scenes 1; .*--resume, or do without them by --skip-failed"):
        merge(parts, tmp_path / "rejected")
    assert merge(parts, tmp_path / "data", skip_failed=True).missing == (1,)
    assert not list((tmp_path / "data").rglob("bop/*/000001"))
    assert {index for found in read_manifest(tmp_path / "data").splits.values() for index in found} == {0, 2}
