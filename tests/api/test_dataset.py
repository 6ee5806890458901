import json
import pickle
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.errors import one_line
from warehouse_sim.api.dataset import Dataset
from warehouse_sim.errors import DatasetError, InputError, OutOfRangeError

pytestmark = pytest.mark.gl


def places(data: Dataset) -> list[tuple[int, int]]:
    return [(obs.scene_id, obs.image_id) for obs in data]


def test_observations_come_by_scene_and_image_over_all_splits(data: Dataset) -> None:
    assert len(data) == 6
    assert places(data) == [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)]
    assert [obs.split for obs in data] == ["train", "train", "val", "val", "test", "test"]
    assert data.splits == {"train": (0,), "val": (1,), "test": (2,)}
    assert data.objects[1].name == "epal1"


def test_it_is_indexed_like_a_list(data: Dataset, smoke: Path) -> None:
    assert (data[3].scene_id, data[3].image_id) == (1, 1)
    assert (data[-1].scene_id, data[np.int64(-2)].image_id) == (2, 0)
    assert places(data[1:5:2]) == [(0, 1), (1, 1)]
    assert places(data[::-1][:2]) == [(2, 1), (2, 0)]
    assert places(data[2:][1:]) == [(1, 1), (2, 0), (2, 1)]
    assert [obs.scene_id for obs in reversed(data)] == [2, 2, 1, 1, 0, 0]
    assert repr(data[:2]) == f"<Dataset smoke at {str(smoke)!r}: 2 observations in 1 scene (train 2)>"


def test_a_split_is_a_dataset(data: Dataset) -> None:
    assert places(data.split("val")) == [(1, 0), (1, 1)]
    assert places(data[3:].split("val")) == [(1, 1)]
    assert len(data.split("val").split("test")) == 0


def test_it_crosses_to_another_process(data: Dataset) -> None:
    again = pickle.loads(pickle.dumps(data.split("val")))
    assert places(again) == [(1, 0), (1, 1)]
    assert np.array_equal(again[0].rgb, data[2].rgb)


@pytest.mark.parametrize("name", ["bop", "kitti", "coco", "yolo/detect"])
def test_the_folder_of_one_format_is_opened_too(smoke: Path, name: str, tmp_path: Path) -> None:
    """Outside of its dataset, as somebody else's."""
    (tmp_path / "theirs").symlink_to(smoke / name)
    data = Dataset(tmp_path / "theirs")
    assert len(data) == 6
    images = {obs.rgb.tobytes() for obs in data}
    assert images == {obs.rgb.tobytes() for obs in Dataset(smoke)}
    assert all(obs.objects for obs in data)


def test_a_dataset_of_kitti_alone_is_opened(smoke: Path, tmp_path: Path) -> None:
    shutil.copytree(smoke, tmp_path / "out", ignore=shutil.ignore_patterns("bop", "coco", "yolo"))
    manifest = tmp_path / "out" / "manifest.json"
    entries = json.loads(manifest.read_text())
    manifest.write_text(json.dumps(entries | {"formats": ["kitti"]}))
    data = Dataset(str(tmp_path / "out"))
    assert len(data) == 6
    assert {obs.depth.shape for obs in data} == {(185, 612)}
    assert all(obs.objects[0].class_name for obs in data)
    manifest.write_text(json.dumps(entries | {"formats": ["ply"]}))
    with pytest.raises(DatasetError, match="was made without a format"):
        Dataset(tmp_path / "out")


def test_the_union_of_two_splits_of_kitti_is_both(smoke: Path) -> None:
    data = Dataset(smoke / "kitti")
    assert [obs.split for obs in data.split("trainval")] == ["train", "train", "val", "val"]


def test_it_shows_itself(data: Dataset) -> None:
    assert "6 observations in 3 scenes (train 2, val 2, test 2)" in repr(data)
    assert "<td>train</td><td>2</td>" in data._repr_html_()


@pytest.mark.parametrize(
    ("call", "kind", "words"),
    [
        (lambda data: data[6], OutOfRangeError, "there is no observation 6; there are 0 to 5"),
        (lambda data: data[-7], IndexError, "there is no observation -7"),
        (lambda data: data[:0][0], OutOfRangeError, "there are none, it is empty"),
        (lambda data: data["a"], InputError, "a whole number or a slice, found 'a'"),
        (lambda data: data[1.0], InputError, "a whole number or a slice, found 1.0"),
        (lambda data: data[True], InputError, "found True"),
        (lambda data: data[::0], InputError, "no step of 0"),
        (lambda data: data["a":2], InputError, "whole numbers"),
        (lambda data: data.split("tset"), DatasetError, "no split 'tset' (did you mean 'test'?); known: train, val"),
        (lambda data: data.split(3), InputError, "name must be text, found 3"),
        (lambda data: Dataset(), InputError, "missing a required argument: 'path'"),
        (lambda data: Dataset(None), InputError, "path must be text or a path, found None"),
        (lambda data: Dataset("nowhere"), DatasetError, "nowhere: is not a folder"),
        (lambda data: Dataset(__file__), DatasetError, "test_dataset.py: is not a folder"),
        (lambda data: Dataset(Path(__file__).parent), DatasetError, "this is no dataset"),
        (lambda data: Dataset(data.path, splt="a"), InputError, "Dataset: got an unexpected keyword argument 'splt'"),
    ],
)
def test_what_cannot_be_is_said_in_one_line(
    data: Dataset, call: Callable[[Dataset], Any], kind: type[Exception], words: str
) -> None:
    with one_line(kind, words):
        call(data)
