"""Front ends on observations that no file holds: rows of files, and weights that an interruption does not change."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import safetensors.numpy
import yaml

from tests.estimators.toy_stream import toy_stream
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import ConfigError, TrainingError
from warehouse_sim.estimators.detectors.settings import DetectorConfig, WantedConfig
from warehouse_sim.estimators.images.rows import image_rows
from warehouse_sim.estimators.images.settings import ImageConfig
from warehouse_sim.estimators.images.streamed import StreamedImages
from warehouse_sim.estimators.segmenters.segnet.settings import SegmenterConfig
from warehouse_sim.estimators.train import train
from warehouse_sim.learning.settings import LoopConfig, StreamConfig
from warehouse_sim.schema import Observation

STREAM = StreamConfig(recipe="toy", seed=99, window=6, fresh=1.5)
CONFIG = DetectorConfig(
    max_minutes=None, max_steps=6, batch=4, size="pico", input_wh=(160, 96), validations=3, precision="32", threads=1,
    workers=2, wanted=WantedConfig(height_px=4), stream=STREAM,
)  # fmt: skip
BOXES = SegmenterConfig(
    max_minutes=None, max_steps=6, batch=4, width=4, validations=3, threads=1, workers=2, stream=STREAM
)


def weights(run: Path) -> dict[str, np.ndarray]:
    found: dict[str, np.ndarray] = safetensors.numpy.load_file(run / "weights.safetensors")
    return found


def test_rows_of_an_observation_are_those_of_its_files(toy_root: Path) -> None:
    reader, config = DatasetReader(toy_root), ImageConfig(("rgb", "depth"), (160, 96), faces=True)
    shown = StreamedImages(toy_stream, replace(STREAM, window=8), config, reader.objects, 4, 0)
    rows = {tuple(part["number"][row]): (part, row) for part in shown.first() for row in range(len(part["number"]))}
    seen = 0
    for split in reader.splits:
        for image in reader.images(split):
            if (found := rows.get((image.scene_id, image.image_id))) is None:
                continue
            seen += 1
            for name, value in image_rows(reader, image, config).items():
                np.testing.assert_array_equal(found[0][name][found[1]], value[0], err_msg=name)
    assert seen >= 6


@pytest.mark.parametrize(("name", "config"), [("detector-rgbd", CONFIG), ("segmenter-depth", BOXES)])
def test_an_interrupted_training_ends_with_the_same_weights(
    name: str, config: LoopConfig, toy_root: Path, tmp_path: Path
) -> None:
    whole = weights(train(name, toy_root, tmp_path / "whole", config, open_stream=toy_stream))
    stopped = 0

    def stops(config: StreamConfig, start: int) -> Iterator[Observation]:
        nonlocal stopped
        for number, item in enumerate(toy_stream(config, start)):
            if number == 11:
                stopped += 1
                raise KeyboardInterrupt
            yield item

    with pytest.raises(KeyboardInterrupt):
        train(name, toy_root, tmp_path / "cut", config, open_stream=stops)
    assert stopped == 1
    cut = weights(train(name, toy_root, tmp_path / "cut", config, resume=True, open_stream=toy_stream))
    for key, value in whole.items():
        np.testing.assert_array_equal(value, cut[key], err_msg=key)
    log = (tmp_path / "cut" / "train.log").read_text(encoding="utf-8")
    assert "train: the stream of toy, seed 99" in log
    assert yaml.safe_load((tmp_path / "cut" / "config.yaml").read_text())["train"]["stream"]["window"] == 6


def test_what_cannot_be_streamed_is_said(toy_root: Path, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="a stream has no sweeps"):
        replace(CONFIG, depth_source="lidar")
    with pytest.raises(ConfigError, match="feeds one process, not 2"):
        replace(CONFIG, devices=2)
    with pytest.raises(TrainingError, match="nothing here opens the stream"):
        train("detector-rgbd", toy_root, tmp_path / "none", CONFIG)
    seed = DatasetReader(toy_root).manifest.seed  # type: ignore[union-attr]
    same = replace(CONFIG, stream=replace(STREAM, seed=seed))
    with pytest.raises(TrainingError, match="whose val split would be trained on"):
        train("detector-rgbd", toy_root, tmp_path / "same", same, open_stream=toy_stream)
    large = replace(CONFIG, wanted=WantedConfig(height_px=90))
    with pytest.raises(TrainingError, match=r"none of the stream's observations, .* larger stream.window"):
        train("detector-rgbd", toy_root, tmp_path / "large", large, open_stream=toy_stream)
