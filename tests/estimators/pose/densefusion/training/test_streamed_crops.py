"""Training on observations that no file holds: the crops of files, and weights that an interruption does not change."""

import json
import logging
import os
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from itertools import count
from pathlib import Path

import numpy as np
import pytest
import safetensors.torch
import torch
from scipy import stats

from tests.dataset.toy import PALLET, make_dataset, make_manifest
from tests.estimators.toy_stream import observed, toy_stream
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.split import SplitConfig, split_scenes
from warehouse_sim.dataset.streamed import ObservedImage, as_stored
from warehouse_sim.errors import ConfigError, TrainingError
from warehouse_sim.estimators.pose.densefusion.crops.crop_set import load_crops
from warehouse_sim.estimators.pose.densefusion.crops.cut import image_crops
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import PoseRun
from warehouse_sim.estimators.pose.densefusion.objects import measure_shape
from warehouse_sim.estimators.pose.densefusion.settings import Balance, CropConfig, TrainConfig
from warehouse_sim.estimators.pose.densefusion.training.streamed_crops import StreamedCrops, sampling_weights
from warehouse_sim.estimators.train import train
from warehouse_sim.learning.settings import StreamConfig
from warehouse_sim.schema import Observation

NAME = "densefusion-pointcloud"
STREAM = StreamConfig(recipe="toy", seed=99, window=4, fresh=1.5)
CONFIG = TrainConfig(max_minutes=None, max_steps=6, batch=4, validations=3, precision="32", threads=1, stream=STREAM)


def weights(run: Path) -> dict[str, torch.Tensor]:
    return safetensors.torch.load_file(run / "weights.safetensors")


@pytest.mark.parametrize(
    "config", [CropConfig(), CropConfig(80, True, True), CropConfig(80, True, True, surround_px=6)]
)
def test_crops_of_an_observation_are_those_of_its_files(toy_root: Path, config: CropConfig) -> None:
    reader, cut = DatasetReader(toy_root), 0
    for split in reader.splits:
        for image in reader.images(split):
            streamed = ObservedImage(as_stored(observed(image.scene_id)[image.image_id]))
            pairs = zip(
                image_crops(reader, image, config, 0), image_crops(streamed, streamed.record, config, 0), strict=True
            )
            for of_file, of_stream in pairs:
                cut += 1
                for name in ("obj_id", "T_camera_object", "points", "border_px", "pixel", "rgb", "depth", "down"):
                    np.testing.assert_array_equal(getattr(of_file, name), getattr(of_stream, name), err_msg=name)
    assert cut > 5


@pytest.fixture(scope="module")
def whole(toy_root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return train(NAME, toy_root, tmp_path_factory.mktemp("streamed") / "run", CONFIG, open_stream=toy_stream)


def test_a_window_that_shows_the_train_split_teaches_the_weights_of_its_files(toy_root: Path, tmp_path: Path) -> None:
    reader = DatasetReader(toy_root)
    shown = [(image.scene_id, image.image_id) for image in reader.images("train")]

    def same(config: StreamConfig, start: int) -> Iterator[Observation]:
        return (as_stored(observed(scene)[number]) for scene, number in shown[start:])

    streams = replace(CONFIG, batch=3, stream=replace(STREAM, window=len(shown), fresh=0.0))
    files = weights(train(NAME, toy_root, tmp_path / "files", replace(streams, stream=StreamConfig())))
    streamed = weights(train(NAME, toy_root, tmp_path / "stream", streams, open_stream=same))
    assert files.keys() == streamed.keys()
    assert all(torch.equal(value, streamed[name]) for name, value in files.items())


STRIDING = replace(STREAM, window=10, fresh=0.4)
"""Moves by one at step 3 and stays until step 6; a run that goes on at step 4 does so between."""


@pytest.mark.parametrize(("stream", "requested"), [(STREAM, [0, 6]), (STRIDING, [0])])
def test_a_run_that_was_interrupted_ends_with_the_same_weights(
    toy_root: Path, tmp_path: Path, stream: StreamConfig, requested: list[int]
) -> None:
    def stop(fraction: float, note: str) -> None:
        if note.startswith("step 5"):
            raise KeyboardInterrupt

    opened: list[int] = []

    def watched(config: StreamConfig, start: int) -> Iterator[Observation]:
        opened.append(start)
        return toy_stream(config, start)

    config, part = replace(CONFIG, stream=stream), tmp_path / "part"
    expected = weights(train(NAME, toy_root, tmp_path / "whole", config, open_stream=toy_stream))
    with pytest.raises(KeyboardInterrupt):
        train(NAME, toy_root, part, config, progress=stop, open_stream=toy_stream)
    train(NAME, toy_root, part, config, resume=True, open_stream=watched)
    assert opened == requested  # where the network begins, then where step 4 goes on, unless that is in sight
    found = weights(part)
    assert all(torch.equal(value, found[name]) for name, value in expected.items())


@pytest.mark.parametrize("balance", ["crops", "objects", "classes"])
def test_every_crop_of_a_window_is_seen_once_in_a_round(toy_root: Path, balance: Balance) -> None:
    shape = measure_shape(DatasetReader(toy_root).objects[PALLET.obj_id], np.random.default_rng(0))
    stream = replace(STREAM, window=16, fresh=0.1)  # 24 crops and strides of 20 steps
    config = replace(CONFIG, seed=5, balance=balance, stream=stream)
    crops = StreamedCrops(toy_stream, config, CropConfig(), [shape], ("pallet",))
    seen, rounds = Counter[int](), []
    for step in range(40):
        if step % 20 == 0:
            seen = Counter()
            rounds.append(seen)
            numbers = range(len(crops.window(step)))
        index = crops.indices(step)
        assert torch.equal(crops.rows(index).points, crops.window(step).rows(index % 2**31).points)
        seen.update((index % 2**31).tolist())
        assert set(seen) <= set(numbers)
        most, least = max(seen.values()), min(seen[number] for number in numbers)
        assert most - least <= 1  # with replacement the fourth round would miss some and show others thrice
    assert [min(times.values()) for times in rounds] == [3, 3]


def test_the_run_says_what_it_was_trained_on(whole: Path) -> None:
    assert PoseRun.read(whole).train.stream == STREAM
    assert "train: the stream of toy, seed 99" in (whole / "train.log").read_text()


def test_scenes_of_the_data_are_rejected(toy_root: Path, tmp_path: Path) -> None:
    seed = DatasetReader(toy_root).manifest.seed  # type: ignore[union-attr]
    config = replace(CONFIG, stream=replace(STREAM, seed=seed))
    with pytest.raises(TrainingError, match=rf"stream.seed {seed} is the seed of .*; choose another one"):
        train(NAME, toy_root, tmp_path / "run", config, open_stream=toy_stream)


def test_a_stream_that_shows_nothing_is_named(toy_root: Path, tmp_path: Path) -> None:
    def empty(config: StreamConfig, start: int) -> Iterator[Observation]:
        return (as_stored(observed(number)[1]) for number in count(start))

    with pytest.raises(TrainingError, match=r"none of the stream's observations .* shows an object of the data"):
        train(NAME, toy_root, tmp_path / "run", CONFIG, open_stream=empty)


def test_settings_that_need_a_stream_are_rejected_without_one(toy_root: Path, tmp_path: Path) -> None:
    with pytest.raises(TrainingError, match="nothing here opens the stream of toy"):
        train(NAME, toy_root, tmp_path / "run", CONFIG)
    with pytest.raises(ConfigError, match="a stream feeds one process, not 2: leave"):
        replace(CONFIG, devices=2)


# Three pallets and one carton: 100, 400, 0 and 4500 crops.
OBJECTS = torch.repeat_interleave(torch.arange(4), torch.tensor([100, 400, 0, 4500]))
CLASSES = ("pallet", "pallet", "pallet", "carton")


def fractions(balance: str) -> list[float]:
    weights = sampling_weights(OBJECTS, CLASSES, balance)
    assert weights.mean() == pytest.approx(1.0, abs=1e-4)
    return [float(weights[number == OBJECTS].sum() / len(OBJECTS)) for number in range(4)]


def test_classes_or_objects_are_drawn_equally_often_and_those_of_a_class_by_the_root() -> None:
    assert fractions("classes") == pytest.approx([0.5 / 3, 1.0 / 3, 0.0, 0.5], abs=1e-3)
    assert fractions("objects") == pytest.approx([1 / 3, 1 / 3, 0.0, 1 / 3], abs=1e-3)
    assert sampling_weights(OBJECTS, CLASSES, "crops") is None
    # A class without crops takes no part.
    weights = sampling_weights(torch.tensor([0, 0, 1, 1]), ("pallet", "carton", "tote"), "classes")
    torch.testing.assert_close(weights, torch.ones(4))


# A training on a stream reaches the score of one on files, on scenes that neither has trained on.


SEEDS = int(os.environ.get("WAREHOUSE_SIM_SCORE_SEEDS", "6"))
SCENES, SPLIT = 60, SplitConfig(0.3, 0.6, 0.1)
STREAM_SCORE_CONFIG = TrainConfig(
    max_minutes=None, max_steps=200, points=128, validations=1, precision="32", threads=1, workers=1, ema=0.98
)
STREAM_SCORE_STREAM = StreamConfig(recipe="toy", seed=99, window=18, fresh=0.25)
"""As many observations at once as the train split shows targets in, and fifty more by the end."""
FIRST = 1000
"""The first scene of the stream; the dataset has none of its scenes."""
_log = logging.getLogger(__name__)


@cache
def observation(number: int) -> Observation:
    """Return the observation of a scene that shows targets."""
    return as_stored(observed(FIRST + number)[0])


def others(config: StreamConfig, start: int) -> Iterator[Observation]:
    return map(observation, count(start))


def median_mm(data: Path, run: Path, config: TrainConfig) -> float:
    """Train, and return the median surface distance on the val split."""
    train(NAME, data, run, config, cache=run.parent / "crops", open_stream=others)
    result = json.loads((run / "result.json").read_text())
    assert result["samples"] == config.max_steps * config.batch
    return result["val_median_mm"]


@pytest.mark.slow
def test_a_stream_teaches_what_files_teach(tmp_path: Path) -> None:
    manifest = replace(make_manifest(SCENES, ("bop",)), splits=dict(split_scenes(SCENES, SPLIT)))
    data = make_dataset(tmp_path / "data", manifest)
    assert len(DatasetReader(data).splits["train"]) == STREAM_SCORE_STREAM.window
    nothing = median_mm(data, tmp_path / "nothing", replace(STREAM_SCORE_CONFIG, max_steps=1))
    scores = np.empty((SEEDS, 2))
    for seed in range(SEEDS):
        for column, stream in enumerate((StreamConfig(), STREAM_SCORE_STREAM)):
            config = replace(STREAM_SCORE_CONFIG, seed=seed, stream=stream)
            scores[seed, column] = median_mm(data, tmp_path / f"{seed}-{column}", config)
        _log.info("seed %d: files %.1f mm, stream %.1f mm", seed, *scores[seed])
    assert scores.max() < 0.5 * nothing, scores
    # Errors are spread by a factor, not by millimetres: the same half as far from either.
    ratio = np.log(scores[:, 1] / scores[:, 0])
    half = stats.t.ppf(0.975, SEEDS - 1) * ratio.std(ddof=1) / np.sqrt(SEEDS)
    low, high = np.exp([ratio.mean() - half, ratio.mean() + half])
    means = np.exp(np.log(scores).mean(axis=0))
    _log.info("files %.1f mm, stream %.1f mm, ratio %.2f (%.2f to %.2f)", *means, np.exp(ratio.mean()), low, high)
    assert low <= 1.0, scores
    assert high < 2.0 * low, scores  # wider, and the trial would not have seen a worse one


# Training reads shards as it reads folders: one image after the other, onto disk, drawn from there by seed.


SHARDS_CONFIG = TrainConfig(max_minutes=None, max_steps=3, batch=4, validations=1, precision="32", threads=1, workers=1)


@pytest.fixture(scope="module", params=["bop_webdataset", "bop_compact"])
def shards(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_dataset(tmp_path_factory.mktemp("shards") / "data", make_manifest(formats=(request.param,)))


def taught(data: Path, run: Path, config: TrainConfig, cache: Path) -> dict[str, torch.Tensor]:
    train("densefusion-pointcloud", data, run, config, cache=cache)
    return safetensors.torch.load_file(run / "weights.safetensors")


def test_shards_teach_what_the_same_images_in_folders_teach(shards: Path, toy_root: Path, tmp_path: Path) -> None:
    of_folders = taught(toy_root, tmp_path / "folders", SHARDS_CONFIG, tmp_path / "cache")
    of_shards = taught(shards, tmp_path / "shards", SHARDS_CONFIG, tmp_path / "cache")
    assert all(torch.equal(value, of_shards[name]) for name, value in of_folders.items())
    other = taught(shards, tmp_path / "other", replace(SHARDS_CONFIG, seed=1), tmp_path / "cache")
    assert any(not torch.equal(value, other[name]) for name, value in of_shards.items())


def test_what_is_cut_out_of_shards_lies_on_disk_and_is_mapped(shards: Path, tmp_path: Path) -> None:
    arrays = load_crops(DatasetReader(shards), "train", CropConfig(), 1, tmp_path / "cache")
    assert arrays is not None
    assert all(isinstance(array, np.memmap) for array in arrays.values())
    assert len(arrays["points"]) > 1
