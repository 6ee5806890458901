"""Scores: predictions in a file against the ground truth of a dataset folder, and a page to look at.

Nothing here needs a network library, a renderer or a simulator.
"""

import logging
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.dataset.stored.scene_record import read_scene_record
from warehouse_sim.errors import EvaluationError
from warehouse_sim.evaluation.bop_scores import bop_scores
from warehouse_sim.evaluation.docking.standing import Standings
from warehouse_sim.evaluation.error_table import ErrorTable
from warehouse_sim.evaluation.errors.surface import ErrorModels
from warehouse_sim.evaluation.measuring import MIN_MODEL_POINTS, MIN_VISIBLE, measure
from warehouse_sim.evaluation.pairing import Place
from warehouse_sim.evaluation.scored_estimates import ScoredEstimates, require_scorable
from warehouse_sim.evaluation.scores import (
    SETTINGS,
    WITHOUT_ACCESSIBILITY,
    WITHOUT_CAD,
    Scores,
    read_scores,
    write_scores,
)
from warehouse_sim.evaluation.summary import docking_failures, docking_left_out, summarise, summarise_groups
from warehouse_sim.evaluation.trust import trust_of
from warehouse_sim.schema import PoseEstimate

log = logging.getLogger(__name__)

__all__ = ["Scores", "evaluate", "read_scores", "write_scores"]


def evaluate(
    predictions: str | Path | Sequence[PoseEstimate],
    data: str | Path | DatasetReader,
    split: str,
    method: str | None = None,
    bop: bool = False,
    vsd: bool = False,
) -> Scores:
    """Score predictions against one split of a dataset.

    Args:
        predictions: File in the BOP pose CSV, or estimates; each must name an image and an object of the split.
        data: Dataset folder, or an open reader of one.
        split: Name of a split, or "all".
        method: Name to store; else that of what predicted, the file name up to the first underscore (the BOP rule), or
            "estimates".
        bop: Whether to add the scores of the BOP challenges, which project every point of every model.
        vsd: Whether these have the recall by VSD, too, and with it the average recall of BOP 2019; implies ``bop``.

    Raises:
        EvaluationError: A prediction names an image or object that the split lacks, translations are not in
            millimetres, or no ground truth counts; VSD is requested without depth images or CAD.
        DatasetError: The dataset or the CSV cannot be read.
    """
    reader = data if isinstance(data, DatasetReader) else DatasetReader(data)
    images = reader.images(split)
    require_scorable(images, split, reader.root)
    given = ScoredEstimates.of(predictions)
    estimates = given.estimates
    if not images:
        raise EvaluationError(
            f"{reader.root}: the split {split!r} has no images; "
            "choose another, or all of them (--split all, split='all')"
        )
    given.check(images, split, reader)
    if given.is_file and not estimates and not given.rejected:
        log.warning("%s: holds no estimate; every object counts as missed", given.name)
    if vsd and not (reader.has_depth and all(info.has_cad for info in reader.objects.values())):
        raise EvaluationError(f"{reader.root}: VSD needs depth images and CAD surfaces; leave --vsd out")
    table = measure(estimates, images, reader.objects, _illuminance(reader, images), Standings.of(reader, images))
    if len(table) == 0:
        raise EvaluationError(
            f"{reader.root}: split {split!r} has no ground truth that is visible enough to count; generate more scenes"
        )
    models, seen = ErrorModels(reader.objects, MIN_MODEL_POINTS), reader.depth if vsd else None
    return Scores(
        method=method or given.method,
        predicted_by=given.predicted_by,
        dataset=_identity(reader, split) | _without_accessibility(table),
        settings=SETTINGS,
        counts=_counts(given, images, table),
        seconds_per_image=given.seconds_per_image(),
        docking_failures=docking_failures(table),
        docking_left_out=docking_left_out(table),
        overall=summarise("all", table),
        groups=summarise_groups(table),
        trust=trust_of(table),
        table=table,
        estimates=estimates,
        bop=bop_scores(estimates, images, models, MIN_VISIBLE, seen) if bop or vsd else None,
    )


def _identity(reader: DatasetReader, split: str) -> dict[str, Any]:
    manifest = reader.manifest
    return {
        "recipe": reader.name,
        "seed": None if manifest is None else manifest.seed,
        "scenes": sum(len(reader.splits[name]) for name in reader.parts),
        "observations_per_scene": None if manifest is None else manifest.observations_per_scene,
        "split": split,
        "manifest_sha256": reader.digest,
        **({} if all(info.has_cad for info in reader.objects.values()) else WITHOUT_CAD),
    }


def _without_accessibility(table: ErrorTable) -> dict[str, str]:
    return WITHOUT_ACCESSIBILITY if bool((table.has_pockets & (table.verdict == "")).any()) else {}


def _counts(given: ScoredEstimates, images: Sequence[ImageRecord], table: ErrorTable) -> dict[str, int]:
    return {
        "scenes": len({image.scene_id for image in images}),
        "images": len(images),
        "ground_truths": len(table),
        "ground_truths_left_out": sum(len(image.targets) for image in images) - len(table),
        "predictions": len(given.estimates),
        "found": int(table.found.sum()),
        "rejected": given.rejected,
    }


def _illuminance(reader: DatasetReader, images: Sequence[ImageRecord]) -> dict[Place, float]:
    """Return the mean illuminance (lx) of the visible surface of each target that the dataset holds it for.

    A dataset made elsewhere has no scene records; its targets are left out.
    """
    layout, found = DatasetLayout(reader.root), dict[Place, float]()
    for scene_id in sorted({image.scene_id for image in images}):
        if not layout.scene_record(scene_id).is_file():
            continue
        for image_id, observation in enumerate(read_scene_record(reader.root, scene_id).observations):
            for target in observation.targets:
                if target.illuminance is not None:
                    found[scene_id, image_id, target.instance_id] = target.illuminance
    return found
