"""A trained front end becomes a bundled model that finds what it found, with a card."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from trainings import bundle as bundling
from trainings import cards
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.estimators.detectors.estimator import DetectConfig, TrainedDetector
from warehouse_sim.estimators.detectors.settings import DetectorConfig, WantedConfig
from warehouse_sim.estimators.detectors.yolov5.network import DetectorRun
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.registries import describe_model
from warehouse_sim.estimators.train import train

CONFIG = DetectorConfig(
    max_minutes=None, max_steps=2, batch=2, size="pico", input_wh=(160, 96), validations=1, wanted=WantedConfig(0.1, 4)
)
ROW = {
    "name": "detector-depth, industrial: pallet",
    "n": 7,
    "box_50": {"value": 0.5, "interval": [0.25, 0.75]},
    "median_ms": 33.4,
}


def test_half_precision_finds_the_same_and_the_card_says_what_it_is(
    toy_root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = train("detector-depth", toy_root, tmp_path / "run", replace(CONFIG, workers=1, threads=1))
    (tmp_path / "models").mkdir()
    monkeypatch.setattr(bundling, "data_folder", lambda name: tmp_path / name)
    model = bundling.bundle(run, "detector-depth")
    image = RgbdImage.from_dataset(*(lambda reader: (reader, reader.images("train")[0]))(DatasetReader(toy_root)), ())
    # Of every cell, before any is left out: rounding decides which of the weakest boxes overlap too much.
    depth = torch.from_numpy(image.depth)[None, :96, :160]
    with torch.inference_mode():
        networks = [DetectorRun.read(folder).load_network(folder) for folder in (run, model)]
        whole, half = (network.decode(network(None, depth)) for network in networks)
    assert len(whole[1][0]) > 300
    torch.testing.assert_close(half[1], whole[1], atol=1e-3, rtol=0)
    torch.testing.assert_close(half[0], whole[0], atol=0.5, rtol=0)
    config = DetectConfig(min_score=0.0)
    found = [[item.score for item in TrainedDetector(folder, config).detect(image)] for folder in (run, model)]
    assert np.allclose(*(scores[:300] for scores in found), atol=1e-3)
    monkeypatch.setattr(cards, "suites", dict)
    monkeypatch.setattr(cards, "_in_layouts", {"detector-depth": [ROW]}.__getitem__)
    text = cards.write(model).read_text()
    for words in (
        "# detector-depth",
        "| finds | pallet |",
        "pico",
        "Apache-2.0",
        "50.0 [25, 75]",
        "samples in 2 steps",
    ):
        assert words in text
    assert describe_model(model) == "detector-depth, industrial: pallet: boxes AP50 50.0 %; 33 ms an image"
