"""Load YOLO's data sets with Ultralytics and supervision; store what masks they saw; print JSON.

Arguments: the folder ``yolo``, an .npz to make.
"""

import json
import os
import sys
from pathlib import Path

os.environ["YOLO_OFFLINE"] = "true"
os.environ["YOLO_VERBOSE"] = "false"
os.environ.setdefault("YOLO_CONFIG_DIR", str(Path(sys.argv[2]).parent))

import numpy as np
import supervision as sv
from ultralytics.data.dataset import YOLODataset
from ultralytics.data.utils import check_det_dataset, polygon2mask

root, out = Path(sys.argv[1]), Path(sys.argv[2])
found, masks = {}, {}
for task in ("detect", "segment", "pose", "obb"):
    data = check_det_dataset(str(root / task / "data.yaml"), autodownload=False)
    for _again in range(2):  # the second time from the cache that the first one left
        dataset = YOLODataset(img_path=data["train"], data=data, task=task, augment=False, imgsz=640)
    stored = np.load(dataset.label_files[0].rsplit(os.sep, 1)[0] + ".cache", allow_pickle=True).item()
    found[task] = {
        "images": len(dataset.labels),
        "rows": sum(len(label["cls"]) for label in dataset.labels),
        "segments": sum(len(label["segments"]) for label in dataset.labels),
        "points": [] if task != "pose" else list(np.concatenate([x["keypoints"] for x in dataset.labels]).shape[1:]),
        "found_missing_empty_corrupt_total": [int(item) for item in stored["results"]],
        "messages": stored["msgs"],
        "names": data["names"],
        "item": sorted(dataset[0]),
    }
    for label in dataset.labels if task == "segment" else ():
        size = np.array(label["shape"][::-1])
        sampled = [polygon2mask(label["shape"], [(s * size).reshape(-1)]) for s in label["segments"]]
        stack = np.array(sampled, dtype=bool).reshape(-1, *label["shape"])
        masks[f"ultralytics/{Path(label['im_file']).stem}"] = np.packbits(stack, axis=None)
    read = sv.DetectionDataset.from_yolo(
        str(root / task / "images/train"),
        str(root / task / "labels/train"),
        str(root / task / "data.yaml"),
        force_masks=task == "segment",
        is_obb=task == "obb",
    )
    found[task]["supervision"] = sum(len(detections) for _, _, detections in read)
    for image_path, image, detections in read if task == "segment" else ():
        stack = detections.mask if len(detections) else np.zeros((0, *image.shape[:2]), dtype=bool)
        masks[f"supervision/{Path(image_path).stem}"] = np.packbits(stack, axis=None)
        masks[f"{Path(image_path).stem}/shape"] = np.array(stack.shape)
np.savez(out, **masks)
print(json.dumps(found))
