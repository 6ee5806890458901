"""From two files to a score: a predictions CSV against one split of a dataset folder."""

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from warehouse_sim.config import to_mapping
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.dataset.stored.scene_record import read_scene_record
from warehouse_sim.errors import EvaluationError
from warehouse_sim.evaluation.bop_scores import BopScores, bop_scores
from warehouse_sim.evaluation.docking.failure import FAILURE_AXES
from warehouse_sim.evaluation.docking.standing import Standings
from warehouse_sim.evaluation.error_table import ErrorTable
from warehouse_sim.evaluation.errors.surface import ErrorModels
from warehouse_sim.evaluation.measure import measure
from warehouse_sim.evaluation.pairing import Place
from warehouse_sim.evaluation.scored_estimates import ScoredEstimates, require_scorable
from warehouse_sim.evaluation.scores import WITHOUT_ACCESSIBILITY, WITHOUT_CAD, ScoreConfig, Scores
from warehouse_sim.evaluation.summary import split_groups, summarise
from warehouse_sim.evaluation.trust import trust_of
from warehouse_sim.schema import PoseEstimate


def evaluate(
    predictions: str | Path | Sequence[PoseEstimate],
    data: str | Path | DatasetReader,
    split: str,
    config: ScoreConfig | None = None,
    method: str | None = None,
    bop: bool = False,
    vsd: bool = False,
) -> Scores:
    """Score predictions against one split of a dataset.

    Args:
        predictions: File in the BOP pose CSV, or estimates; each must name an image and an object of the split.
        data: Dataset folder, or an open reader of one.
        split: Name of a split, or "all".
        config: Settings; the defaults if None.
        method: Name to store; else the file name up to the first underscore (the BOP rule), or "estimates".
        bop: Whether to add the scores of the BOP challenges, which project every point of every model.
        vsd: Whether these have the recall by VSD, too, and with it the average recall of BOP 2019; implies ``bop``.

    Raises:
        EvaluationError: A prediction names an image or object that the split lacks, translations are not in
            millimetres, or no ground truth counts; VSD is requested without depth images or CAD.
        DatasetError: The dataset or the CSV cannot be read.
    """
    config = config or ScoreConfig()
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
    standings = Standings.of(reader, images)
    table = measure(estimates, images, reader.objects, config.measure, _illuminance(reader, images), standings)
    if len(table) == 0:
        raise EvaluationError(
            f"{reader.root}: split {split!r} has no ground truth that is visible enough to count; "
            "generate more scenes, or lower measure.min_visible_fraction (without CAD measure.min_model_points)"
        )
    groups = {
        name: tuple(summarise(label, table.select(rows), config.metrics, config.groups) for label, rows in group)
        for name, group in split_groups(table, config.groups).items()
    }
    if (table.verdict != "").any():
        stacks = {"alone": table.select(table.stacked == 0), "stacked": table.as_stacks()}
        groups["stacking"] = tuple(
            summarise(label, part, config.metrics, config.groups) for label, part in stacks.items()
        )
    return Scores(
        method=method or given.method,
        dataset=_identity(reader, split) | _without_accessibility(table),
        settings=to_mapping(config),
        counts=_counts(estimates, images, table) | {"rejected": given.rejected},
        overall=summarise("all", table, config.metrics, config.groups),
        groups=groups,
        docking_failures=docking_failures(table),
        docking_left_out=docking_left_out(table, config.metrics.docking_margin_mm),
        trust=trust_of(table, config.groups),
        seconds_per_image=_seconds_per_image(estimates),
        table=table,
        estimates=estimates,
        bop=_bop(estimates, images, reader, config, vsd) if bop or vsd else None,
    )


def _bop(
    estimates: Sequence[PoseEstimate],
    images: Sequence[ImageRecord],
    reader: DatasetReader,
    config: ScoreConfig,
    vsd: bool,
) -> BopScores:
    if vsd and not (reader.has_depth and all(info.has_cad for info in reader.objects.values())):
        raise EvaluationError(f"{reader.root}: VSD needs depth images and CAD surfaces; leave --vsd out")
    models = ErrorModels(reader.objects, config.measure.min_model_points)
    seen = reader.depth if vsd else None
    return bop_scores(estimates, images, models, config.measure.min_visible_fraction, seen)


def docking_failures(table: ErrorTable) -> dict[str, int]:
    """Count the ground truths that cannot be docked (no margin) by the error to blame, "missed" for no estimate."""
    failed = table.limiting_error[table.evaluated() & ~table.docks()]
    return {axis: int((failed == axis).sum()) for axis in (*FAILURE_AXES, "missed")}


def docking_left_out(table: ErrorTable, margins_mm: Sequence[int]) -> dict[str, int]:
    """Count the ground truths with pockets for which docking is not evaluated, by reason, the most frequent first.

    Those in stacks come under "stacked" whatever their faces; those that a truck can take and that do not leave a
    margin at the true pose under "no clearance for 20 mm", which holds for that margin alone.
    """
    pockets, stacked = table.has_pockets, table.stacked == 1
    blocked = Counter(table.verdict[pockets & ~table.dockable & ~stacked].tolist())
    found = dict(blocked.most_common())
    tight = {f"no clearance for {k} mm": int((table.dockable & ~table.evaluated(k / 1000.0)).sum()) for k in margins_mm}
    counts = {"stacked": int((pockets & stacked).sum())} | found | tight
    return {reason: count for reason, count in counts.items() if count}


def _identity(reader: DatasetReader, split: str) -> dict[str, Any]:
    manifest = reader.manifest
    return {
        "recipe": reader.name,
        "seed": None if manifest is None else manifest.seed,
        "scenes": sum(map(len, reader.splits.values())),
        "observations_per_scene": None if manifest is None else manifest.observations_per_scene,
        "split": split,
        "manifest_sha256": reader.digest,
        **({} if all(info.has_cad for info in reader.objects.values()) else WITHOUT_CAD),
    }


def _without_accessibility(table: ErrorTable) -> dict[str, str]:
    return WITHOUT_ACCESSIBILITY if bool((table.has_pockets & (table.verdict == "")).any()) else {}


def _counts(estimates: Sequence[PoseEstimate], images: Sequence[ImageRecord], table: ErrorTable) -> dict[str, int]:
    return {
        "scenes": len({image.scene_id for image in images}),
        "images": len(images),
        "ground_truths": len(table),
        "ground_truths_left_out": sum(len(image.targets) for image in images) - len(table),
        "predictions": len(estimates),
        "found": int(table.found.sum()),
    }


def _seconds_per_image(estimates: Sequence[PoseEstimate]) -> float | None:
    times = {(item.scene_id, item.image_id): item.time for item in estimates if item.time >= 0.0}
    return round(float(np.mean(list(times.values()))), 6) if times else None


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
