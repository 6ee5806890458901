"""Training reads shards as it reads folders: one image after the other, onto disk, drawn from there by seed."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import safetensors.torch
import torch

from tests.dataset.toy import make_dataset, make_manifest
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.estimators.pose.densefusion.crops.crop_set import load_crops
from warehouse_sim.estimators.pose.densefusion.settings import CropConfig, TrainConfig
from warehouse_sim.estimators.train import train

CONFIG = TrainConfig(max_minutes=None, max_steps=3, batch=4, validations=1, precision="32", threads=1, workers=1)


@pytest.fixture(scope="module", params=["bop_webdataset", "bop_compact"])
def shards(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_dataset(tmp_path_factory.mktemp("shards") / "data", make_manifest(formats=(request.param,)))


def weights(data: Path, run: Path, config: TrainConfig, cache: Path) -> dict[str, torch.Tensor]:
    train("densefusion-pointcloud", data, run, config, cache=cache)
    return safetensors.torch.load_file(run / "weights.safetensors")


def test_shards_teach_what_the_same_images_in_folders_teach(shards: Path, toy_root: Path, tmp_path: Path) -> None:
    of_folders = weights(toy_root, tmp_path / "folders", CONFIG, tmp_path / "cache")
    of_shards = weights(shards, tmp_path / "shards", CONFIG, tmp_path / "cache")
    assert all(torch.equal(value, of_shards[name]) for name, value in of_folders.items())
    other = weights(shards, tmp_path / "other", replace(CONFIG, seed=1), tmp_path / "cache")
    assert any(not torch.equal(value, other[name]) for name, value in of_shards.items())


def test_what_is_cut_out_of_shards_lies_on_disk_and_is_mapped(shards: Path, tmp_path: Path) -> None:
    arrays = load_crops(DatasetReader(shards), "train", CropConfig(), 1, tmp_path / "cache")
    assert arrays is not None
    assert all(isinstance(array, np.memmap) for array in arrays.values())
    assert len(arrays["points"]) > 1
