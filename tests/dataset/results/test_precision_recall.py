"""Average precision against pycocotools, which counts its own way."""

import contextlib
import io

import numpy as np
import pytest
from pycocotools.coco import COCO
from pycocotools.cocoeval import COCOeval

from warehouse_sim.dataset.results.precision_recall import Matches, average_precision, match
from warehouse_sim.geometry.boxes import box_coverage, box_ious


def random_images(seed: int) -> list[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
    """Return ground-truth boxes, which are wanted, detections and their scores of some images."""
    rng, images = np.random.default_rng(seed), []
    for _ in range(30):
        low = rng.uniform(0, 300, (rng.integers(0, 9), 2))
        gt = np.concatenate([low, low + rng.uniform(10, 120, low.shape)], axis=1)
        near = gt[rng.random(len(gt)) < 0.8] if len(gt) else gt
        near = near + rng.normal(0, 8, near.shape)
        low = rng.uniform(0, 300, (rng.integers(0, 4), 2))
        stray = np.concatenate([low, low + rng.uniform(10, 120, low.shape)], axis=1)
        found = np.concatenate([near, near[: len(near) // 3] + 4, stray])
        found[:, 2:] = np.maximum(found[:, 2:], found[:, :2] + 5)
        images.append((gt, rng.random(len(gt)) < 0.8, found, rng.random(len(found))))
    return images


def of_pycocotools(images: list, overlap: float) -> float:
    rows, found = [], []
    for number, (gt, wanted, boxes, scores) in enumerate(images):
        for box, requested in zip(gt, wanted, strict=True):
            w, h = box[2:] - box[:2]
            rows.append({"id": len(rows) + 1, "image_id": number, "category_id": 1, "bbox": [box[0], box[1], w, h],
                         "area": w * h, "iscrowd": int(not requested)})  # fmt: skip
        for box, score in zip(boxes, scores, strict=True):
            w, h = box[2:] - box[:2]
            found.append({"image_id": number, "category_id": 1, "bbox": [box[0], box[1], w, h], "score": score})
    with contextlib.redirect_stdout(io.StringIO()):
        coco = COCO()
        coco.dataset = {"images": [{"id": number} for number in range(len(images))], "annotations": rows,
                        "categories": [{"id": 1}]}  # fmt: skip
        coco.createIndex()
        evaluation = COCOeval(coco, coco.loadRes(found), "bbox")
        evaluation.params.iouThrs = np.array([overlap])
        evaluation.evaluate()
        evaluation.accumulate()
    precision = evaluation.eval["precision"][0, :, 0, 0, -1]
    return float(precision[precision > -1].mean())


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("overlap", [0.5, 0.75])
def test_average_precision_is_that_of_pycocotools(seed: int, overlap: float) -> None:
    images = random_images(seed)
    rows = []
    for gt, wanted, found, scores in images:
        overlaps = np.where(wanted, box_ious(found, gt), box_coverage(found, gt))
        rows.append(match(scores, overlaps, wanted, overlap))
    assert average_precision(rows) == pytest.approx(of_pycocotools(images, overlap), abs=1e-9)


def test_nothing_to_find_has_no_precision() -> None:
    nothing = np.zeros(0)
    assert np.isnan(average_precision([Matches(nothing, nothing.astype(bool), nothing.astype(bool), 0)]))
    assert average_precision([Matches(nothing, nothing.astype(bool), nothing.astype(bool), 3)]) == 0.0
