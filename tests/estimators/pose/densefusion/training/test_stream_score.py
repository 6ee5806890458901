"""A training on a stream reaches the score of one on files, on scenes that neither has trained on."""

import json
import logging
import os
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from itertools import count
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from tests.dataset.toy import make_dataset, make_manifest, make_scene, observe
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.split import SplitConfig, split_scenes
from warehouse_sim.dataset.streamed import as_stored
from warehouse_sim.estimators.pose.densefusion.settings import TrainConfig
from warehouse_sim.estimators.train import train
from warehouse_sim.learning.settings import StreamConfig
from warehouse_sim.schema import Observation

pytestmark = pytest.mark.slow

SEEDS = int(os.environ.get("WAREHOUSE_SIM_SCORE_SEEDS", "6"))
SCENES, SPLIT = 60, SplitConfig(0.3, 0.6, 0.1)
NAME = "densefusion-pointcloud"
CONFIG = TrainConfig(
    max_minutes=None, max_steps=200, points=128, validations=1, precision="32", threads=1, workers=1, ema=0.98
)
STREAM = StreamConfig(recipe="toy", seed=99, window=18, fresh=0.25)
"""As many observations at once as the train split shows targets in, and fifty more by the end."""
FIRST = 1000
"""The first scene of the stream; the dataset has none of its scenes."""
_log = logging.getLogger(__name__)


@cache
def observation(number: int) -> Observation:
    """Return the observation of a scene that shows targets."""
    return as_stored(observe(make_scene(FIRST + number))[0])


def others(config: StreamConfig, start: int) -> Iterator[Observation]:
    return map(observation, count(start))


def median_mm(data: Path, run: Path, config: TrainConfig) -> float:
    """Train, and return the median surface distance on the val split."""
    train(NAME, data, run, config, cache=run.parent / "crops", open_stream=others)
    result = json.loads((run / "result.json").read_text())
    assert result["samples"] == config.max_steps * config.batch
    return result["val_median_mm"]


def test_a_stream_teaches_what_files_teach(tmp_path: Path) -> None:
    manifest = replace(make_manifest(SCENES, ("bop",)), splits=dict(split_scenes(SCENES, SPLIT)))
    data = make_dataset(tmp_path / "data", manifest)
    assert len(DatasetReader(data).splits["train"]) == STREAM.window
    nothing = median_mm(data, tmp_path / "nothing", replace(CONFIG, max_steps=1))
    scores = np.empty((SEEDS, 2))
    for seed in range(SEEDS):
        for column, stream in enumerate((StreamConfig(), STREAM)):
            config = replace(CONFIG, seed=seed, stream=stream)
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
