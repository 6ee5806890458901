import json
import os
import signal
import threading
import time
from dataclasses import replace
from pathlib import Path

import pytest

from tests.processes import scene_workers
from tests.shared import hashes
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.store import DatasetStore
from warehouse_sim.dataset.validate import validate
from warehouse_sim.errors import ConfigError, DatasetError, UnknownNameError
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import load_recipe

KNOWN = "known: bop, bop_compact, bop_webdataset, coco, folder, kitti, linemod, mcap, pcd, ply, yolo"

pytestmark = pytest.mark.gl


@pytest.fixture(scope="module")
def recipe():
    return load_recipe("smoke")


@pytest.fixture(scope="module")
def dataset(shared) -> Path:
    return shared.dataset(scenes=3)


def test_a_generated_dataset_passes_every_check(dataset) -> None:
    assert [check for check in validate(dataset) if not check.ok] == []


def test_splits_share_no_scene_and_every_split_has_targets(dataset) -> None:
    reader = DatasetReader(dataset)
    scenes = {split: {image.scene_id for image in reader.images(split)} for split in ("train", "val", "test")}
    assert sum(len(ids) for ids in scenes.values()) == len(set.union(*scenes.values())) == 3
    assert all(any(image.targets for image in reader.images(split)) for split in scenes)


def test_same_seed_same_bytes_with_two_workers_of_which_one_is_killed(shared, tmp_path, caplog) -> None:
    def kill_one() -> None:
        while not (workers := scene_workers(os.getpid())):
            time.sleep(0.02)
        os.kill(workers[0], signal.SIGKILL)

    assert scene_workers(os.getpid()) == []
    killer = threading.Thread(target=kill_one)
    killer.start()
    generate(load_recipe(str(shared.bare)), tmp_path / "again", GenerateConfig(scenes=3, workers=2, formats=("bop",)))
    killer.join()
    assert "was ended by SIGKILL" in caplog.text
    assert hashes(tmp_path / "again") == hashes(shared.dataset(shared.bare, scenes=3, formats=("bop",)))


def test_an_interrupted_run_is_rejected_then_resumed_to_the_same_bytes(shared, tmp_path, monkeypatch) -> None:
    recipe, dataset = load_recipe(str(shared.bare)), shared.dataset(shared.bare, scenes=3, formats=("bop",))
    root, config = tmp_path / "data", GenerateConfig(scenes=3, formats=("bop",))
    write_scene = DatasetStore.write_scene

    def killed_in_scene_1(self, scene, observations, *more, **named) -> None:
        if scene.scene_index == 1:
            observations = iter(())  # the observation never comes
        write_scene(self, scene, observations, *more, **named)

    monkeypatch.setattr(DatasetStore, "write_scene", killed_in_scene_1)
    with pytest.raises(DatasetError, match="scene 1"):
        generate(recipe, root, config)
    monkeypatch.undo()
    assert not (root / "manifest.json").exists()
    with pytest.raises(DatasetError, match="incomplete"):
        DatasetReader(root)
    with pytest.raises(DatasetError, match="not empty"):
        generate(recipe, root, config)
    paths = [root / "scenes/000000.json", *(root / "bop/train/000000").rglob("*.*")]
    finished = {path: path.stat().st_mtime_ns for path in paths}
    assert len(finished) > 5
    generate(recipe, root, replace(config, resume=True))
    assert {path: path.stat().st_mtime_ns for path in finished} == finished
    assert hashes(root) == hashes(dataset)


def test_a_scene_alone_equals_the_same_scene_of_a_larger_dataset(shared, dataset) -> None:
    one, all_ = hashes(shared.dataset(scenes=1) / "bop" / "train"), hashes(dataset / "bop" / "train" / "000000")
    assert {name.removeprefix("000000/"): value for name, value in one.items()} == all_


def test_the_manifest_says_how_to_make_it_again(dataset) -> None:
    manifest = json.loads((dataset / "manifest.json").read_text())
    assert manifest["seed"] == 0
    assert manifest["recipe"]["name"] == "smoke"
    assert manifest["packages"]["mujoco"]
    assert len(manifest["renderers"]) == 1


def test_unknown_formats_and_backends_list_the_known_ones(recipe, tmp_path) -> None:
    with pytest.raises(UnknownNameError, match=KNOWN):
        generate(recipe, tmp_path / "a", GenerateConfig(formats=("coco3",)))
    with pytest.raises(UnknownNameError, match="raster"):
        generate(recipe, tmp_path / "b", GenerateConfig(backend="vulkan"))
    with pytest.raises(ConfigError, match="a dataset needs one at least"):
        generate(recipe, tmp_path / "b", GenerateConfig(formats=()))
    assert not (tmp_path / "b").exists()
