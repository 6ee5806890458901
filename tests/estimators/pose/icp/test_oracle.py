"""The sensor's ceiling: the labels' poses stay where the depth is exact, and leave them where it is not."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.dataset.toy import make_dataset
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import InputError
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.pose.icp.oracle import OracleIcp
from warehouse_sim.estimators.predict import predict
from warehouse_sim.estimators.settings import PredictConfig


@pytest.fixture(scope="module")
def toy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_dataset(tmp_path_factory.mktemp("oracle") / "data")


def test_it_stays_near_the_labels_and_follows_depth_that_is_off(toy: Path) -> None:
    reader = DatasetReader(toy)
    image = next(item for split in reader.splits for item in reader.images(split) if item.targets)
    estimator = OracleIcp()
    estimator.onboard(reader.objects)
    estimator.show([image])
    seen = RgbdImage.from_dataset(reader, image, image.targets)
    off = replace(seen, depth=np.where(seen.depth > 0, seen.depth + np.float32(0.03), 0))
    moved = []
    for looked_at in (seen, off):
        for found in estimator.estimate(looked_at):
            label = next(item for item in image.targets if item.gt_index == found.detection)
            moved.append(found.T_camera_object[2, 3] - label.T_camera_object[2, 3])
    half = len(moved) // 2
    assert half > 0
    assert np.abs(np.median(moved[:half])) < 0.015
    assert np.median(moved[half:]) > np.median(moved[:half]) + 0.01


def test_what_is_no_label_cannot_be_started_at(toy: Path) -> None:
    split = next(iter(DatasetReader(toy).splits))
    assert predict("oracle-icp", toy, split)
    with pytest.raises(InputError, match="starts at the poses of the labels"):
        predict("oracle-icp", toy, split, PredictConfig(detections="gt-boxes+cluster"))
