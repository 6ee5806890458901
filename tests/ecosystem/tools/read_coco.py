"""Read COCO tables with pycocotools, faster-coco-eval and supervision; store what masks they saw; print JSON.

Arguments: the folder ``coco``, a split, an .npz to make.
"""

import contextlib
import io
import json
import sys
from pathlib import Path

import faster_coco_eval
import numpy as np
import supervision as sv
from pycocotools.coco import COCO
from pycocotools.cocoeval import COCOeval

root, split, out = Path(sys.argv[1]), sys.argv[2], Path(sys.argv[3])
found, masks = {}, {}
for table in ("instances", "instances_amodal"):
    path = root / "annotations" / f"{table}_{split}.json"
    with contextlib.redirect_stdout(io.StringIO()):
        coco = COCO(str(path))
        kept = [row for row in coco.anns.values() if not row["iscrowd"]]
        answers = [
            {key: row[key] for key in ("image_id", "category_id", "bbox", "segmentation")} | {"score": 1.0}
            for row in kept
        ]
        scores = []
        for make, evaluate in ((COCO, COCOeval), (faster_coco_eval.COCO, faster_coco_eval.COCOeval_faster)):
            gt = make(str(path))
            for kind in ("bbox", "segm"):
                given = [dict(row, segmentation=dict(row["segmentation"])) for row in answers]
                judge = evaluate(gt, gt.loadRes(given), kind)
                judge.evaluate()
                judge.accumulate()
                judge.summarize()
                scores.append(float(judge.stats[0]))
    dataset = sv.DetectionDataset.from_coco(str(root / split), str(path), force_masks=True)
    count = 0
    for image_path, image, detections in dataset:
        assert image is not None
        stack = detections.mask if len(detections) else np.zeros((0, *image.shape[:2]), dtype=bool)
        masks[f"{table}/{Path(image_path).stem}"] = np.packbits(stack, axis=None)
        masks[f"{table}/{Path(image_path).stem}/shape"] = np.array(stack.shape)
        count += len(detections)
    found[table] = {
        "images": len(coco.imgs),
        "annotations": len(coco.anns),
        "scores": scores,
        "supervision": count,
        "classes": dataset.classes,
    }
np.savez(out, **masks)
print(json.dumps(found))
