"""Score chain, network and ceiling in nine layouts with the rigs of their recipes, on scenes of no training.

python -m benchmarks.front_ends.layouts [--weights warehouses] [--only selective_rack] [--methods ceiling]

Weights are bundled ones: those for any layout, whose names end in -warehouses, or those of one hall, whose names have
no ending. Rows go to benchmarks/results/layouts.json.
"""

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import tyro

from benchmarks.speed.result import RESULTS, beside_stored, rounded, write_result
from trainings.data import TARGETS, Data, made
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.results.detections import read_results, write_results
from warehouse_sim.dataset.split import SplitConfig
from warehouse_sim.estimators.predict import detect, predict
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.evaluation import Scores, evaluate
from warehouse_sim.evaluation.any_name import under_any_name
from warehouse_sim.evaluation.detection.scores import Evaluated, Seen, precision_intervals, seen_by_class, wanted_in
from warehouse_sim.evaluation.error_table import ErrorTable
from warehouse_sim.evaluation.intervals import fraction_interval

FOLDER = Path("out/layouts")
LAYOUTS = (
    "selective_rack",
    "very_narrow_aisle",
    "drive_in",
    "dock_staging",
    "block_storage",
    "mixed_pallets",
    "conveyor_pickup",
    "industrial",
    "domain_random",
)
Weights = Literal["warehouses", "industrial"]
ENDINGS: dict[Weights, str] = {"warehouses": "-warehouses", "industrial": ""}
"""Of the names of bundled weights: for any layout, and of the hall of the recipe ``industrial``."""
_SEED, _SCENES, _VIEWS = 515_151, 6, 8
_RESAMPLES = 1000
_DEPTH = ("detector-depth", "segmenter-depth")
_FRONT_ENDS = {
    "boxes": _DEPTH[:1],
    "masks": _DEPTH,
    "masks, depth and RGB": (*_DEPTH, "segmenter-rgb"),
    "boxes, RGB": ("detector-rgb",),
    "boxes, depth and RGB": ("detector-depth", "detector-rgb"),
}
_IN_CHAINS: dict[Weights, str] = {"warehouses": "masks, depth and RGB", "industrial": "masks"}
"""Of ``_FRONT_ENDS``, what stands before pose estimators."""
_LEAST_SCORE = 0.05
"""Of boxes that precision is counted over."""
_FOUND = "found"
"""Stands for the boxes and masks of the front end."""
_SEEN = Evaluated(0.1, 8.0, (0.0, 10.0))
"""What is to be found: a tenth of it visible, within 10 m; by what reads depth, half of its pixels measured."""
_NEAR, _WELL_SEEN = 7.0, 0.3
"""Of a network alone: within so many metres, with at least so much visible."""


@dataclass(frozen=True)
class Method:
    """What is scored."""

    estimator: str
    config: PredictConfig


METHODS = {
    "ceiling": Method("oracle-icp", PredictConfig(detections="gt")),
    "icp-multistart": Method("icp-multistart", PredictConfig(detections="gt")),
    "densefusion-depth, ground-truth masks": Method("densefusion-depth", PredictConfig(detections="gt")),
    "densefusion-depth alone": Method("densefusion-depth", PredictConfig(detections="gt", refine="none")),
    "densefusion-depth, from pixels": Method("densefusion-depth", PredictConfig(detections=_FOUND)),
}
UNTRAINED = ("ceiling", "icp-multistart")


def data(layout: str) -> Data:
    """Return the dataset of a layout."""
    test = SplitConfig(0.0, 0.0, 1.0)
    return Data(layout, _SEED, f"layout_{layout}", _SCENES, _VIEWS, test, targets=TARGETS)


def main(
    folder: Path = FOLDER,
    only: tuple[str, ...] = (),
    methods: tuple[str, ...] = (),
    weights: Weights = "warehouses",
    workers: int = os.cpu_count() or 1,
) -> None:
    """Predict, score, print and store.

    Args:
        folder: Where data are kept, and what was found.
        only: Layouts; all by default.
        methods: Of ``METHODS`` and ``_FRONT_ENDS``; all by default.
        weights: Which ones.
        workers: Processes that generate.
    """
    file = RESULTS / "layouts.json"
    for layout in only or LAYOUTS:
        root = made(data(layout), folder, workers)
        for method in methods or (*_bundled(weights), *METHODS):
            kept = folder / "found" / f"{layout}-{weights}.json"
            measured = _found(method, weights, root, kept) if method in _FRONT_ENDS else _docked(method, weights, root)
            whose = "" if method in UNTRAINED else weights
            name = f"{layout}: {method}" + (f" ({whose})" if whose else "")
            row = rounded({"name": name, "layout": layout, "method": method, "weights": whose, **measured})
            print(row, flush=True)
            write_result(file, "python -m benchmarks.front_ends.layouts", beside_stored(file, [row]))


def _bundled(weights: Weights) -> list[str]:
    """Return those of ``_FRONT_ENDS`` that are for such weights; colour helps depth in those for any layout alone."""
    return [name for name in _FRONT_ENDS if weights == "warehouses" or "depth and RGB" not in name]


def _front_end(method: str, weights: Weights) -> str:
    """Return the stages of one of ``_FRONT_ENDS``, joined by +."""
    return "+".join(f"{name}{ENDINGS[weights]}" for name in _FRONT_ENDS[method])


def _found(method: str, weights: Weights, root: Path, file: Path) -> dict[str, Any]:
    """Write what a front end finds, and return its AP at 0.5 of pallets; in colour alone also of people and trucks."""
    reader = DatasetReader(root)
    file.parent.mkdir(parents=True, exist_ok=True)
    # Masks share pixels out among all boxes: those of a chain are the ones that it would take.
    has_masks = any(stage.startswith("segmenter") for stage in _FRONT_ENDS[method])
    min_score = None if has_masks else _LEAST_SCORE
    objects, seconds = detect(_front_end(method, weights), root, "test", min_score=min_score)
    write_results(file, [item for item in objects if item.class_name in TARGETS], reader)
    seen = replace(_SEEN, measured=0.5) if _DEPTH[0] in _FRONT_ENDS[method] else _SEEN
    parts = seen_by_class(read_results(file, reader, "test"), reader, reader.images("test"), seen)
    row = _precision(parts["pallet"]) | {"median_ms": 1000 * float(np.median(seconds))}
    others = TARGETS[1:] if _FRONT_ENDS[method] == ("detector-rgb",) else ()
    return row | {name: _precision(parts[name]) for name in others if name in parts and wanted_in(parts[name])}


def _precision(parts: Sequence[Seen]) -> dict[str, Any]:
    precisions = precision_intervals(parts, _RESAMPLES, np.random.default_rng(0))
    value, low, high = precisions["mask_50" if "mask_50" in precisions else "box_50"]
    return {"value": value, "interval": [low, high], "n": wanted_in(parts)}


def _docked(method: str, weights: Weights, root: Path) -> dict[str, Any]:
    """Return the fractions with ADD under a tenth of the diameter, and docked of the pallets that a truck can take.

    A wrong kind counts as a miss; from pixels, ``docked_any_name`` says what docks all the same.
    """
    estimator, config = METHODS[method].estimator, METHODS[method].config
    if config.detections == _FOUND:
        config = replace(config, detections=_front_end(_IN_CHAINS[weights], weights))
    ending = ENDINGS[weights] if method not in UNTRAINED else ""
    poses, reader = predict(f"{estimator}{ending}", root, "test", config), DatasetReader(root)
    scores = evaluate(poses, reader, "test", method=estimator)
    table = _pallets(scores)
    can = table.select(table.dockable)
    docked = {"docked": _fraction(can.docks(), can)} if len(can) else {}
    if docked and METHODS[method].config.detections == _FOUND:
        renamed = _pallets(evaluate(under_any_name(poses, reader, "test"), reader, "test"))
        named = renamed.select(renamed.dockable)
        docked["docked_any_name"] = _fraction(named.docks(), named)
    near = table.select((table.distance <= _NEAR) & (table.visible_fraction >= _WELL_SEEN))
    return {
        **_fraction(table.add < 0.1 * table.diameter, table),
        **docked,
        "add_10pct_near": _fraction(near.add < 0.1 * near.diameter, near),
        "seconds_an_image": scores.seconds_per_image,
    }


def _pallets(scores: Scores) -> ErrorTable:
    return scores.table.select(scores.table.class_name == "pallet")


def _fraction(right: np.ndarray, table: ErrorTable) -> dict[str, Any]:
    low, high = fraction_interval(right.astype(float), table.scene_id, _RESAMPLES, np.random.default_rng(0))
    return {"value": float(right.mean()), "interval": [low, high], "n": len(table)}


if __name__ == "__main__":
    tyro.cli(main)
