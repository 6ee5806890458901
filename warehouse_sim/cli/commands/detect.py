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
from warehouse_sim.output import make_folder

_LEAST_SCORE = 0.05


def detect(
    detector: tyro.conf.Positional[str],
    out: Path,
    data: Path | None = None,
    images: Path | None = None,
    split: str = "test",
    labels: Path | None = None,
    visible: float = 0.1,
    height_px: float = 8.0,
    min_score: float | None = None,
    overwrite: bool = False,
) -> None:
    """Find objects in images; those of a dataset's split are scored against its labels.

    Args:
        detector: Detector or segmenter by name or run folder, or a file of detections, or several joined by +.
        out: JSON file to write: COCO's results, which ``predict --detections FILE`` takes; of photographs COCO's object
            with images, categories and annotations.
        data: Dataset folder.
        images: Folder of photographs in place of a dataset, for what reads colour alone; nothing is scored.
        split: Split to look at, or all of them.
        labels: Folder for the same as YOLO's label files, with scores.
        visible: Least visible fraction of what is to be found, 0-1.
        height_px: Least height of what is to be found (px), >= 0.
        min_score: Detections of lower scores are left out, 0-1; by default 0.17 (of sweeps 0.25), of photographs 0.05,
            for precision over recall wants many.
        overwrite: Replace the JSON file where there is one.
    """
    require_extra("learn", "to detect")
    if (data is None) == (images is None):
        raise InputError("name either a dataset with --data DIR or photographs with --images DIR")
    require_free(out, overwrite)
    if min_score is not None and not 0.0 <= min_score <= 1.0:
        raise InputError(f"--min-score must be 0-1, found {min_score:g}")
    if data is None:
        assert images is not None
        if (split, labels, visible, height_px) != ("test", None, 0.1, 8.0):
            raise InputError(
                "--split, --labels, --visible and --height-px are of datasets: leave them out with --images"
            )
        _photographs(detector, images, out, _LEAST_SCORE if min_score is None else min_score)
        return
    if not 0.0 <= visible <= 1.0 or not 0.0 <= height_px < inf:
        raise InputError(f"--visible must be 0-1 and --height-px at least 0, found {visible:g} and {height_px:g}")
    from warehouse_sim.dataset.reader import DatasetReader
    from warehouse_sim.dataset.results.detections import write_labels, write_results
    from warehouse_sim.estimators.predict import detect as find
    from warehouse_sim.evaluation.detection.scores import Evaluated, score_detections

    reader = DatasetReader(data)
    with fraction_progress("detecting") as progress:
        found, seconds = find(detector, data, split, progress, min_score)
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
    if not reader.has_depth:
        finish(out, "view", data, "--summary")
        return
    poses = "--split", split, "--out", out.with_suffix(".csv"), "--detections", out
    finish(out, "predict", "densefusion-depth", "--data", data, *poses)


def _photographs(detector: str, images: Path, out: Path, min_score: float) -> None:
    from warehouse_sim.dataset.files.json_file import write_json
    from warehouse_sim.estimators.predict.photographs import find_in_photographs

    with fraction_progress("detecting") as progress:
        found = find_in_photographs(detector, images, progress, min_score)
    make_folder(out.parent)
    write_json(out, found)
    print(f"{len(found['annotations'])} found in {len(found['images'])} photographs")
    finish(out)
