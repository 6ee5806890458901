import numpy as np

from warehouse_sim.estimators.detectors.yolov5.anchors import anchor_recall, cluster_anchors
from warehouse_sim.estimators.detectors.yolov5.network import ANCHORS


def test_clusters_are_found_again() -> None:
    rng = np.random.default_rng(1)
    true = np.array([[20, 4], [40, 9], [60, 6], [90, 30], [150, 25], [200, 80]], dtype=float)
    boxes = np.repeat(true, 300, axis=0) * np.exp(rng.normal(0, 0.05, (1800, 2)))
    found = cluster_anchors(boxes, 6, rng)
    np.testing.assert_allclose(found.anchors_wh, true[true.prod(axis=1).argsort()], rtol=0.03)
    assert found.recall == 1.0


def test_wide_boxes_want_wide_anchors() -> None:
    rng = np.random.default_rng(2)
    width = np.exp(rng.uniform(np.log(25), np.log(220), 2000))
    boxes = np.stack([width, width / rng.uniform(4, 9, 2000)], axis=1)
    assert anchor_recall(boxes, np.array(ANCHORS)) < 0.97
    assert cluster_anchors(boxes, 9, rng).recall == 1.0


def test_fewer_boxes_than_anchors_suffice() -> None:
    found = cluster_anchors(np.array([[50.0, 10.0]]), 9, np.random.default_rng(3))
    assert found.anchors_wh.shape == (9, 2)
    assert np.isfinite(found.anchors_wh).all()
    assert found.recall == 1.0
