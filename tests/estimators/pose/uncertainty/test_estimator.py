"""What judges estimates is told the network's confidence, whatever else their scores count."""

from dataclasses import replace

import numpy as np
import pytest

from tests.dataset.toy import PALLET
from tests.estimators.toy_stream import observed
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.pose.uncertainty import estimator
from warehouse_sim.schema import Agreement, PoseEstimate


def test_features_have_the_confidence_of_the_network_and_not_the_score(monkeypatch: pytest.MonkeyPatch) -> None:
    image = RgbdImage.from_observation(observed(0)[0])
    found = replace(image.detections[0], number=7, score=0.5)
    seen: list[float] = []
    monkeypatch.setattr(estimator, "look", lambda *args: seen.append(args[4]))
    watch = estimator.Watcher(lambda number: PALLET.mesh(), 0)
    pose = PoseEstimate(image.scene_id, image.image_id, 1, 0.03, np.eye(4), detection=7)
    network = replace(pose, agreement=Agreement(confidence=0.8))
    fit = replace(pose, agreement=Agreement(margin=1.0))
    watch([replace(image, detections=(found,))], [network, fit, pose])
    assert seen == pytest.approx([0.4, 0.03, 0.03])
