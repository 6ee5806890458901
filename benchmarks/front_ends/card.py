"""The card of a bundled front end: what it is, how it was made, what it finds where, and what it cannot do."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import yaml

from benchmarks.result import percent_cell
from trainings.bundle import FIRST_STAGE
from warehouse_sim.estimators.detectors.yolov5.network import DetectorRun
from warehouse_sim.estimators.lidar.sweep.network import SweepRun
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import PoseRun
from warehouse_sim.estimators.segmenters.segnet.network import SegmenterRun
from warehouse_sim.estimators.train import trainable
from warehouse_sim.learning.run_folder import Source, read_kind

_METRICS = {"box_50": "boxes AP50", "box_75": "AP75", "mask_50": "masks AP50", "mask_75": "AP75"}

_MOST_NAMED = 12
"""Datasets that a card names one by one."""
_EVALUATED = (
    "Unseen scenes (`benchmarks/front_ends/data.py`), average precision in % with 95 % intervals over scenes; misses "
    "count, and hardly visible objects are ignored. PQ: panoptic quality of masks with a score of 0.5 or more."
)


def write(model: Path, rows: Sequence[dict[str, Any]]) -> Path:
    """Write ``card.md`` and, for programs, ``card.yaml`` of a model's folder.

    Args:
        model: Folder of the model.
        rows: Those of benchmarks/results/front_ends.json.
    """
    mine = [row for row in rows if row["stages"][-1] == model.name]
    lines = [
        f"# {model.name}",
        "",
        *description(model),
        "",
        "## Scores",
        "",
        _EVALUATED,
        "",
        "| evaluated on | n | " + " | ".join(_METRICS.values()) + " | PQ |",
        "|---|---|" + "---|" * (len(_METRICS) + 1),
        *(_row(row) for row in mine),
        "",
        "## Limits",
        "",
        "- Trained and scored on synthetic images of this package only.",
        "- It may miss objects that are unlike its training data, or report them as pallets.",
    ]
    if mine:
        best = mine[0]
        kind = "mask_50" if "mask_50" in best else "box_50"
        score = f"{best['name']}: {_METRICS[kind]} {100 * best[kind]['value']:.1f} %"
        speed = {"speed": f"{best['median_ms']:.0f} ms an image"} if "median_ms" in best else {}
        (model / "card.yaml").write_text(yaml.safe_dump({"score": score, **speed}, sort_keys=False), encoding="utf-8")
    path = model / "card.md"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def description(model: Path) -> list[str]:
    """Return the lines that say what a model is and how it was made."""
    config: DetectorRun | SegmenterRun | SweepRun | PoseRun
    result = json.loads((model / "result.json").read_text(encoding="utf-8"))
    if (kind := read_kind(model)) == "segmenter":
        config = SegmenterRun.read(model)
        size, seen = f"{config.network.width} filters and more", "boxes"
        finds = "masks" + (" and key points of pallet faces" if config.network.keypoints else "")
    elif kind == "densefusion":
        config = PoseRun.read(model)
        size, seen = config.train.size, "crops"
        finds = f"poses of {len(config.objects)} objects"
    else:
        config = (SweepRun if kind == "sweep-detector" else DetectorRun).read(model)
        size, seen, finds = config.train.size, "images", ", ".join(config.classes)
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
        "licence": "Apache-2.0; trained on synthetic data of this package alone",
        "all settings": "[config.yaml](config.yaml); curves in [curves.csv](curves.csv)",
    }
    method = trainable(config.estimator)
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


def _sources(datasets: Sequence[Source]) -> str:
    if len(datasets) > _MOST_NAMED:
        return (
            f"{len(datasets)} datasets of `trainings/warehouses.py`, whose numbers are their seeds; "
            "digests of the manifests in config.yaml"
        )
    data = ", ".join(f"`{item.name}` ({item.sha256[:12]})" for item in datasets)
    return f"train splits of {data}; seeds in `trainings/data.py`, digests of the manifests"


def _row(row: dict[str, Any]) -> str:
    cells = [percent_cell(row.get(metric)) for metric in _METRICS]
    quality = row.get("panoptic_quality")
    return f"| {row['name']} | {row['n']} | {' | '.join(cells)} | {f'{100 * quality:.1f}' if quality else '-'} |"
