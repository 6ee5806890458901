"""What has a name: estimators, detectors, segmenters, kinds of run folders; and what the card of a bundled model says.

A name of ``ESTIMATORS``, ``DETECTORS`` or ``SEGMENTERS`` stands for something that is called without arguments and
returns one, or for something that first is trained.
"""

import json
from pathlib import Path
from typing import Any

from warehouse_sim.estimators.api import Trainable
from warehouse_sim.registry import Registry
from warehouse_sim.yaml_file import read_yaml

ESTIMATORS = Registry("estimator")
for _name in (
    "densefusion",
    "densefusion-early",
    "densefusion-middle-1",
    "densefusion-middle-2",
    "densefusion-depth",
    "densefusion-pointcloud",
    "object-coordinates",
):
    _constant = _name.upper().replace("-", "_")
    ESTIMATORS.add(_name, f"warehouse_sim.estimators.pose.densefusion.methods:{_constant}")
ESTIMATORS.add("rectangle-fit", "warehouse_sim.estimators.pose.fitting.fit:rectangle_fit")
ESTIMATORS.add("icp-multistart", "warehouse_sim.estimators.pose.fitting.fit:icp_multistart")
ESTIMATORS.add("front-fit", "warehouse_sim.estimators.pose.faces.estimator:front_fit")
for _name in (
    "detect-densefusion",
    "detect-depth",
    "detect-keypoints",
    "segment-densefusion",
    "segment-densefusion-early",
    "segment-densefusion-middle-1",
    "segment-densefusion-middle-2",
    "segment-densefusion-depth",
    "segment-densefusion-pointcloud",
    "segment-object-coordinates",
    "segment-rectangle-fit",
    "segment-icp-multistart",
    "segment-front-fit",
):
    ESTIMATORS.add(_name, f"warehouse_sim.estimators.load:{_name.upper().replace('-', '_')}")
ESTIMATORS.add("detect-pointcloud", "warehouse_sim.estimators.lidar.pointcloud:DETECT_POINTCLOUD")
ESTIMATORS.add("lidar-direct", "warehouse_sim.estimators.lidar.direct:LIDAR_DIRECT")
DETECTORS = Registry("detector")
for _name in ("detector-rgb", "detector-depth", "detector-rgbd", "detector-lidar"):
    _constant = _name.upper().replace("-", "_")
    DETECTORS.add(_name, f"warehouse_sim.estimators.detectors.yolov5.settings:{_constant}")
for _name in ("rtdetr-rgb", "rtdetr-depth", "rtdetr-rgbd"):
    DETECTORS.add(_name, f"warehouse_sim.estimators.detectors.rtdetr.settings:{_name.upper().replace('-', '_')}")
DETECTORS.add("detector-sweep", "warehouse_sim.estimators.lidar.sweep.settings:DETECTOR_SWEEP")
SEGMENTERS = Registry("segmenter")
for _name in ("segmenter-rgb", "segmenter-depth", "segmenter-rgbd", "keypoints-rgb", "keypoints-rgbd"):
    _constant = _name.upper().replace("-", "_")
    SEGMENTERS.add(_name, f"warehouse_sim.estimators.segmenters.segnet.settings:{_constant}")
SEGMENTERS.add("cluster", "warehouse_sim.estimators.segmenters.cluster:BoxClusters")
FAMILIES = Registry("kind of run folder", group="warehouse_sim.estimator_families")
FAMILIES.add("densefusion", "warehouse_sim.estimators.pose.densefusion.estimator:Estimator")
FRONT_ENDS = Registry("kind of run folder that finds objects", group="warehouse_sim.front_end_families")
FRONT_ENDS.add("detector", "warehouse_sim.estimators.detectors.estimator:TrainedDetector")
FRONT_ENDS.add("sweep-detector", "warehouse_sim.estimators.lidar.sweep.estimator:TrainedSweepDetector")
FRONT_ENDS.add("rtdetr", "warehouse_sim.estimators.detectors.rtdetr.estimator:TrainedRtdetr")
FRONT_ENDS.add("segmenter", "warehouse_sim.estimators.segmenters.segnet.estimator:TrainedSegmenter")


def is_trainable(registered: Any) -> bool:
    """Return whether what a name stands for must be trained first."""
    return isinstance(registered, Trainable) and not isinstance(registered, type)


def trained_names() -> list[str]:
    """Return the names of ``ESTIMATORS`` that must be trained first; each is imported."""
    return [name for name in ESTIMATORS.names() if is_trainable(ESTIMATORS.get(name))]


CARD, RESULT = "card.yaml", "result.json"


def describe_model(folder: Path) -> str:
    """Return score and speed of a bundled model: what its card says, else what its training saw on val.

    ``card.yaml`` may hold ``score`` and ``speed``, each one short text.
    """
    if (folder / CARD).is_file():
        card = read_yaml(folder / CARD)
        return "; ".join(str(card[key]) for key in ("score", "speed") if isinstance(card, dict) and key in card)
    if (folder / RESULT).is_file():
        result = json.loads((folder / RESULT).read_text(encoding="utf-8"))
        if "val_within_5_percent" in result:
            return f"val: {result['val_within_5_percent']:.1f} % within 5 % of the diameter"
    return "bundled"
