"""A few images, seen often, are known by heart: average precision counted by pycocotools."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pycocotools.coco import COCO
from pycocotools.cocoeval import COCOeval

from tests.estimators.detectors.rtdetr.conftest import CONFIG
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.estimators.detectors.estimator import DetectConfig
from warehouse_sim.estimators.detectors.rtdetr.network import TrainedRtdetr
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.images import compose
from warehouse_sim.estimators.images.settings import ImageAugmentConfig
from warehouse_sim.estimators.train import train

AS_THEY_ARE = ImageAugmentConfig(zoom=1)


@pytest.mark.slow
def test_what_is_seen_often_is_found(library, toy_root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compose, "_MOSAIC", 0.0)
    monkeypatch.setattr(compose, "_SHIFT", 0.0)
    monkeypatch.setattr(compose, "_FLIP", 0.0)
    monkeypatch.setattr(compose, "_ERRORS", compose.ImageErrors(0.0, 0.0, 0.0, 0, 0.0))
    config = replace(CONFIG, max_steps=200, input_wh=(160, 96), learning_rate=1e-3, ema=0.9, augment=AS_THEY_ARE)
    detector = TrainedRtdetr(
        train("rtdetr-depth", toy_root, tmp_path / "run", config, cache=Path("none")), DetectConfig(min_score=0.01)
    )
    reader = DatasetReader(toy_root)
    gt, found = list[dict](), list[dict]()
    images = reader.images("train")
    for number, image in enumerate(images, start=1):
        for target in image.targets:
            left, top, right, bottom = target.box_visible_xyxy
            box = [left, top, right - left + 1, bottom - top + 1]
            hidden = target.visible_fraction < 0.1 or box[3] < 4
            row = {"id": len(gt) + 1, "image_id": number, "category_id": 1, "bbox": box, "area": box[2] * box[3]}
            gt.append({**row, "iscrowd": int(hidden)})
        for detection in detector.detect(RgbdImage.from_dataset(reader, image, ())):
            left, top, right, bottom = np.add(detection.box_xyxy, 0.5)
            box = [left, top, right - left, bottom - top]
            found.append({"image_id": number, "category_id": 1, "bbox": box, "score": detection.score})
    assert coco_ap50(len(images), gt, found) >= 0.95


def coco_ap50(images: int, gt: list[dict], found: list[dict]) -> float:
    coco = COCO()
    numbers = [{"id": number} for number in range(1, images + 1)]
    coco.dataset = {"images": numbers, "annotations": gt, "categories": [{"id": 1}]}
    coco.createIndex()
    scored = COCOeval(coco, coco.loadRes(found), "bbox")
    scored.evaluate()
    scored.accumulate()
    scored.summarize()
    return float(scored.stats[1])
