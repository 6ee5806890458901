"""A trained RT-DETR: images in, boxes with classes and scores out."""

from pathlib import Path

from warehouse_sim.estimators.detectors.boxes import BoxNetwork
from warehouse_sim.estimators.detectors.estimator import DetectConfig, TrainedDetector
from warehouse_sim.estimators.detectors.rtdetr.run_config import load_network, read_config
from warehouse_sim.estimators.detectors.run_config import AnyRunConfig

RTDETR_DETECT = DetectConfig(most_overlap=0.9)
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

    def __init__(self, run: Path, config: DetectConfig = RTDETR_DETECT) -> None:
        super().__init__(run, config)

    def _opened(self, run: Path) -> tuple[AnyRunConfig, BoxNetwork]:
        config = read_config(run)
        return config, load_network(run, config)
