import json
from dataclasses import replace
from pathlib import Path

import pytest

from tests.dataset.toy import make_manifest, with_recipe
from warehouse_sim.dataset.manifest import load_manifest, package_versions, read_manifest, write_manifest
from warehouse_sim.errors import DatasetError


def test_round_trip(tmp_path: Path) -> None:
    manifest = replace(with_recipe(make_manifest(7), {"scene": {"bays": [1, 2.5]}}), renderers=("llvmpipe 1.2",))
    write_manifest(tmp_path / "manifest.json", manifest)
    assert read_manifest(tmp_path) == manifest


def test_nothing_of_place_is_in_it(toy_root: Path) -> None:
    assert str(toy_root) not in (toy_root / "manifest.json").read_text()


def test_scene_finds_its_split() -> None:
    manifest = make_manifest(10)
    assert [manifest.split_of(i) for i in (0, 6, 7, 8, 9)] == ["train", "train", "val", "test", "test"]
    with pytest.raises(DatasetError, match="scene 10 is not in the dataset; it has scenes 0 to 9"):
        manifest.split_of(10)


def test_versions_name_python_and_numpy() -> None:
    assert {"python", "numpy", "opencv-python-headless"} <= set(package_versions())


def test_folders_without_manifest(tmp_path: Path) -> None:
    with pytest.raises(DatasetError, match="is not a folder"):
        read_manifest(tmp_path / "none")
    with pytest.raises(DatasetError, match="this is no dataset"):
        read_manifest(tmp_path)
    (tmp_path / "manifest.unfinished.json").touch()
    with pytest.raises(DatasetError, match=r"no manifest\.json: the dataset is incomplete; resume it with .* --resume"):
        read_manifest(tmp_path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"seed": -1}, "seed must be >= 0"),
        ({"sead": 3}, "sead is not a setting; did you mean 'seed'?"),
        ({"scenes": 1_000_000_000}, "splits must hold every scene exactly once"),
        ({"splits": {"train": [0, 1], "val": [1], "test": [2]}}, "splits must hold every scene exactly once"),
        ({"splits": {"train": [0, 1, 2], "val": [], "eval": []}}, "splits must hold every scene exactly once"),
        ({"format_version": 2}, "format_version 2 is not readable"),
    ],
)
def test_wrong_manifests_are_rejected(toy_root: Path, tmp_path: Path, change: dict, message: str) -> None:
    data = json.loads((toy_root / "manifest.json").read_text()) | change
    (tmp_path / "manifest.json").write_text(json.dumps(data))
    with pytest.raises(DatasetError) as caught:
        load_manifest(tmp_path / "manifest.json")
    assert message in str(caught.value)
    assert str(tmp_path / "manifest.json") in str(caught.value)
