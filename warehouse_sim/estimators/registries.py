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
DETECTORS = Registry("detector")
SEGMENTERS = Registry("segmenter")
FAMILIES = Registry("kind of run folder", group="warehouse_sim.estimator_families")
FRONT_ENDS = Registry("kind of run folder that finds objects", group="warehouse_sim.front_end_families")
_FUSIONS = (
    "densefusion",
    *(f"densefusion-{kind}" for kind in ("early", "middle-1", "middle-2", "depth", "pointcloud")),
)
_POSES = (*_FUSIONS, "object-coordinates")
_CONSTANTS: tuple[tuple[Registry, str, tuple[str, ...]], ...] = (
    (ESTIMATORS, "pose.densefusion.methods", _POSES),
    (ESTIMATORS, "load", ("recommended", "detect-densefusion", "detect-depth", "detect-keypoints")),
    (
        ESTIMATORS,
        "load",
        tuple(f"segment-{name}" for name in (*_POSES, "rectangle-fit", "icp-multistart", "front-fit")),
    ),
    (ESTIMATORS, "lidar.pointcloud", ("detect-pointcloud",)),
    (ESTIMATORS, "lidar.direct", ("lidar-direct",)),
    (DETECTORS, "detectors.settings", tuple(f"detector-{name}" for name in ("rgb", "depth", "rgbd", "lidar"))),
    (DETECTORS, "lidar.sweep.settings", ("detector-sweep",)),
    (SEGMENTERS, "segmenters.segnet.settings", tuple(f"segmenter-{name}" for name in ("rgb", "depth", "rgbd"))),
    (SEGMENTERS, "segmenters.segnet.settings", ("keypoints-rgb", "keypoints-rgbd")),
)
"""Which names are constants of which module, each called as its name in capitals."""
for _registry, _module, _names in _CONSTANTS:
    for _name in _names:
        _registry.add(_name, f"warehouse_sim.estimators.{_module}:{_name.upper().replace('-', '_')}")
ESTIMATORS.add("rectangle-fit", "warehouse_sim.estimators.pose.fitting.fit:rectangle_fit")
ESTIMATORS.add("icp-multistart", "warehouse_sim.estimators.pose.fitting.fit:PoseFit")
ESTIMATORS.add("oracle-icp", "warehouse_sim.estimators.pose.icp.oracle:OracleIcp")
ESTIMATORS.add("fpfh-fgr", "warehouse_sim.estimators.pose.fpfh:FpfhFgr")
ESTIMATORS.add("front-fit", "warehouse_sim.estimators.pose.faces.estimator:FaceEstimator")
SEGMENTERS.add("cluster", "warehouse_sim.estimators.segmenters.cluster:BoxClusters")
FAMILIES.add("densefusion", "warehouse_sim.estimators.pose.densefusion.estimator:Estimator")
FRONT_ENDS.add("detector", "warehouse_sim.estimators.detectors.estimator:TrainedDetector")
FRONT_ENDS.add("sweep-detector", "warehouse_sim.estimators.lidar.sweep.estimator:TrainedSweepDetector")
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
