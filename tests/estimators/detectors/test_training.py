"""Training on the toy warehouse, as a person starts it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import safetensors.numpy
import torch

from warehouse_sim.cli.main import main
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.results.detections import write_results
from warehouse_sim.errors import InputError, TrainingError
from warehouse_sim.estimators.detectors.estimator import TrainedDetector
from warehouse_sim.estimators.detectors.settings import DetectorConfig, WantedConfig
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.load import load_estimator
from warehouse_sim.estimators.predict import detect, predict
from warehouse_sim.estimators.registries import DETECTORS
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.estimators.train import train

CONFIG = DetectorConfig(
    max_minutes=None,
    max_steps=15,
    batch=4,
    size="pico",
    input_wh=(160, 96),
    validations=3,
    ema=0.9,
    learning_rate=4e-3,
    threads=1,
    workers=1,
    wanted=WantedConfig(height_px=4),
)


@pytest.fixture(scope="module")
def run(toy_root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return train("detector-rgbd", toy_root, tmp_path_factory.mktemp("detector") / "run", CONFIG)


def test_the_number_of_threads_changes_no_weight(toy_root: Path, tmp_path: Path) -> None:
    # The last of six steps has no mosaics, which the one before cannot know.
    config = replace(CONFIG, max_steps=6, validations=1, precision="32")
    for workers in (1, 3):
        train("detector-rgbd", toy_root, tmp_path / str(workers), replace(config, workers=workers))
    a, b = (safetensors.numpy.load_file(tmp_path / name / "weights.safetensors") for name in ("1", "3"))
    for name, value in a.items():
        np.testing.assert_array_equal(value, b[name], err_msg=name)


def test_what_is_found_is_what_a_pose_estimator_works_on(run: Path, toy_root: Path, tmp_path: Path) -> None:
    # So little trained, it is sure of nothing.
    found = sorted(detect(str(run), toy_root, "test", min_score=0.001)[0], key=lambda item: -item.score)[:12]
    write_results(tmp_path / "boxes.json", found, DatasetReader(toy_root))
    poses = predict("rectangle-fit", toy_root, "test", PredictConfig(detections=str(tmp_path / "boxes.json")))
    assert 0 < len(poses) <= len(found)
    places = [(pose.scene_id, pose.image_id, pose.detection) for pose in poses]
    assert len(set(places)) == len(places)
    assert {place[:2] for place in places} <= {(item.scene_id, item.image_id) for item in found}


def test_a_look_at_the_mirror_image_gives_the_edges_of_the_image(run: Path, toy_root: Path) -> None:
    image = RgbdImage.from_dataset(*_first(toy_root), ())
    assert image.rgb is not None
    mirrored = replace(image, rgb=image.rgb[:, ::-1].copy(), depth=image.depth[:, ::-1].copy())
    detector, width = TrainedDetector(run), image.camera.width
    with torch.inference_mode():
        found, expected = detector._look(image, 1.0, True, 0.001), detector._look(mirrored, 1.0, False, 0.001)
    assert len(found.boxes) > 0
    np.testing.assert_allclose(found.scores, expected.scores, atol=1e-3)
    turned = np.column_stack(
        [width - expected.boxes[:, 2], expected.boxes[:, 1], width - expected.boxes[:, 0], expected.boxes[:, 3]]
    )
    np.testing.assert_allclose(found.boxes, turned, atol=0.1)


def test_wrong_uses_are_told_in_one_line(run: Path, toy_root: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="--detections"):
        load_estimator(run)
    with pytest.raises(TrainingError, match="no target is of the class 'truck'"):
        train("detector-rgb", toy_root, tmp_path / "a", replace(CONFIG, classes=("truck",)))
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "config.yaml").write_bytes((run / "config.yaml").read_bytes())
    with pytest.raises(TrainingError, match="not of detector-rgb"):
        train("detector-rgb", toy_root, tmp_path / "b", CONFIG, resume=True)
    image = RgbdImage.from_dataset(*_first(toy_root), (), rgb=False)
    with pytest.raises(InputError, match="has no rgb"):
        TrainedDetector(run).detect(image)


def test_a_command_trains_a_detector_with_settings_of_its_own(
    toy_root: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "run"
    words = ["train", "detector-depth", "--data", str(toy_root), "--out", str(out), "--max-steps", "2", "--batch", "2"]
    more = ["--size", "pico", "--input-wh", "160", "96", "--wanted.height-px", "3", "--validations", "1"]
    assert main([*words, *more]) == 0
    assert "detect" in capsys.readouterr().out
    assert (out / "result.json").is_file()
    assert main(["train", "detector-depht", "--data", str(toy_root), "--out", str(tmp_path / "no")]) == 2
    assert "detector-depth" in capsys.readouterr().err


def test_a_detector_without_bundled_weights_says_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("warehouse_sim.learning.trainable.model_names", lambda: [])
    with pytest.raises(TrainingError, match="train it first"):
        DETECTORS.get("detector-rgb")()


def _first(root: Path):
    reader = DatasetReader(root)
    return reader, reader.images("train")[0]
