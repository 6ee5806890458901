"""``warehouse-sim detect``: a detector and a dataset become a file of detections, and their scores."""

from math import inf
from pathlib import Path

import numpy as np
import tyro
from rich.console import Console
from rich.table import Table

from warehouse_sim.cli.checks import require_free
from warehouse_sim.cli.console import finish, fraction_progress
from warehouse_sim.errors import InputError
from warehouse_sim.optional import require_extra


def detect(
    detector: tyro.conf.Positional[str],
    data: Path,
    out: Path,
    split: str = "test",
    labels: Path | None = None,
    visible: float = 0.1,
    height_px: float = 8.0,
    overwrite: bool = False,
) -> None:
    """Find objects in the images of a split, write them as COCO's results, and score them against the labels.

    Args:
        detector: Detector or segmenter by name or run folder, or a file of detections, or several joined by +.
        data: Dataset folder.
        out: JSON file to write; ``predict --detections FILE`` takes it.
        split: Split to look at, or all of them.
        labels: Folder for the same as YOLO's label files, with scores.
        visible: Least visible fraction of what is to be found, 0-1.
        height_px: Least height of what is to be found (px), >= 0.
        overwrite: Replace the JSON file where there is one.
    """
    require_extra("learn", "to detect")
    require_free(out, overwrite)
    if not 0.0 <= visible <= 1.0 or not 0.0 <= height_px < inf:
        raise InputError(f"--visible must be 0-1 and --height-px at least 0, found {visible:g} and {height_px:g}")
    from warehouse_sim.dataset.reader import DatasetReader
    from warehouse_sim.dataset.results.detections import write_labels, write_results
    from warehouse_sim.estimators.predict import detect as find
    from warehouse_sim.evaluation.detection.scores import Evaluated, score_detections

    reader = DatasetReader(data)
    with fraction_progress("detecting") as progress:
        found, seconds = find(detector, data, split, progress)
    write_results(out, found, reader)
    if labels is not None:
        write_labels(labels, found, reader, split)
    table = Table(box=None)
    for heading in ("class", "to be found", "box AP50", "AP75", "AP", "mask AP50", "AP75", "AP", "PQ"):
        table.add_column(heading)
    for row in score_detections(found, reader, reader.images(split), Evaluated(visible, height_px)):
        values = [row.precision.get(name) for name in ("box_50", "box_75", "box", "mask_50", "mask_75", "mask")]
        cells = ["-" if value is None else f"{100 * value:.1f}" for value in (*values, row.panoptic_quality)]
        table.add_row(row.class_name, str(row.wanted), *cells)
    Console(highlight=False, width=140).print(table)
    print(f"{len(found)} found in {len(seconds)} images, {1000 * float(np.median(seconds)):.0f} ms an image (median)")
    poses = "--split", split, "--out", out.with_suffix(".csv"), "--detections", out
    finish(out, "predict", "densefusion-depth", "--data", data, *poses)
