"""Training on the toy warehouse, as a person starts it."""

from dataclasses import replace
from pathlib import Path

import pytest
import torch

from tests.estimators.detectors.rtdetr.conftest import CONFIG
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.detections import open_front_end
from warehouse_sim.estimators.detectors.estimator import TrainedDetector
from warehouse_sim.estimators.detectors.rtdetr.network import RTDETR_DETECT, TrainedRtdetr
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.train import train

MEMORY = Path("none")


def test_a_run_folder_detects_and_another_training_begins_with_it(run: Path, toy_root: Path, tmp_path: Path) -> None:
    reader = DatasetReader(toy_root)
    image = RgbdImage.from_dataset(reader, reader.images("train")[0], ())
    detector = TrainedRtdetr(run, replace(RTDETR_DETECT, min_score=0.001))
    found = detector.detect(image)
    assert 0 < len(found) <= 100
    assert {detection.class_name for detection in found} == {"pallet"}
    assert open_front_end(run)(image) is not None
    with pytest.raises(TrainingError, match="of the kind rtdetr, not detector"):
        TrainedDetector(run)
    # What inference left in the library's caches must not be in the way of training.
    small = replace(CONFIG, max_steps=1, validations=1)
    other = train("rtdetr-depth", toy_root, tmp_path / "run", small, init=run, cache=MEMORY)
    log = (other / "train.log").read_text()
    assert f"tensors from {run / 'weights.safetensors'}; fresh: model.backbone.model.embedder" in log
    assert "started_from" in (other / "config.yaml").read_text()


def test_a_pallet_behind_another_is_not_suppressed(run: Path, toy_root: Path) -> None:
    detector = TrainedRtdetr(run)
    boxes = torch.tensor([[[10.0, 10.0, 50.0, 40.0], [14.0, 10.0, 54.0, 40.0], [10.0, 10.5, 50.0, 40.0]]])
    scores = torch.tensor([[[0.9], [0.8], [0.7]]])
    detector._network.decode = lambda raw: (boxes, scores)  # type: ignore[method-assign]
    reader = DatasetReader(toy_root)
    found = detector.detect(RgbdImage.from_dataset(reader, reader.images("train")[0], ()))
    # Overlaps of 0.82 and 0.98 with the first.
    assert [detection.score for detection in found] == pytest.approx([0.9, 0.8])


@pytest.mark.gpu
@pytest.mark.skipif(not torch.cuda.is_available(), reason="no CUDA device")
def test_a_gpu_trains_and_detects(toy_root: Path, tmp_path: Path) -> None:
    made = train("rtdetr-rgbd", toy_root, tmp_path / "run", CONFIG, cache=MEMORY)
    reader = DatasetReader(toy_root)
    TrainedRtdetr(made).detect(RgbdImage.from_dataset(reader, reader.images("train")[0], ()))
    assert '"device": "cuda' in (made / "result.json").read_text()
