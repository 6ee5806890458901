"""A trained RT-DETR: images in, boxes with classes and scores out."""

from pathlib import Path
from typing import ClassVar

from warehouse_sim.estimators.detectors.boxes import BoxRun
from warehouse_sim.estimators.detectors.estimator import DetectConfig, TrainedDetector
from warehouse_sim.estimators.detectors.rtdetr.network import RtdetrRun

RTDETR_DETECT = DetectConfig(max_overlap=0.9)
"""Each object is taught to one box only: what overlaps less is another object, such as pallets behind each other."""


class TrainedRtdetr(TrainedDetector):
    """The RT-DETR of a run folder.

    Args:
        run: Run folder, or folder of a bundled model.
        config: What counts as found.

    Raises:
        TrainingError: The folder holds no complete run of an RT-DETR.
        MissingPackageError: The library is not installed.
    """

    opens: ClassVar[type[BoxRun]] = RtdetrRun

    def __init__(self, run: Path, config: DetectConfig = RTDETR_DETECT) -> None:
        super().__init__(run, config)
