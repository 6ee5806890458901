"""Every error of every ground truth that counts: the rows that scores are made of."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from warehouse_sim.dataset.reader import ImageRecord, ObjectInfo
from warehouse_sim.evaluation.docking.fork import ForkConfig
from warehouse_sim.evaluation.docking.standing import Standings
from warehouse_sim.evaluation.error_table import ErrorTable, table_from_columns
from warehouse_sim.evaluation.errors.surface import ErrorModels
from warehouse_sim.evaluation.illuminance import Place
from warehouse_sim.evaluation.object_columns import object_columns
from warehouse_sim.evaluation.pairing import Pair, pair_up
from warehouse_sim.schema import PoseEstimate


@dataclass(frozen=True)
class MeasureConfig:
    """What counts as a ground truth, and what must fit into its pockets."""

    min_visible_fraction: float = 0.1
    """Ground truths with a smaller visible fraction are left out (0-1), as in BOP."""
    min_model_points: int = 50
    """Ground truths whose model is a cloud of fewer points are left out, >= 1: 50, as in the study of 6D poses on KITTI
    that docs/evaluation.md names, which has figures for 100, too. Those with CAD all count."""
    fork: ForkConfig = field(default_factory=ForkConfig)
    """The tines that must enter the pockets."""


def measure(
    predictions: Sequence[PoseEstimate],
    images: Sequence[ImageRecord],
    objects: Mapping[int, ObjectInfo],
    config: MeasureConfig,
    illuminance: Mapping[Place, float] | None = None,
    standings: Standings | None = None,
) -> ErrorTable:
    """Match predictions to the ground truths of ``images`` and measure the errors of each.

    Args:
        predictions: Estimates; every scene, image and object must be among ``images`` and ``objects``.
        images: Images with their targets.
        objects: Geometry by object id.
        config: What counts, and how it is measured.
        illuminance: Of the ground truths (lx), as far as it is known.
        standings: How they stand in their scenes; None is not known.

    Returns:
        One row a counted ground truth, by scene, image and position in the image.
    """
    models = ErrorModels(objects, config.min_model_points)
    pairs = pair_up(predictions, images, models, config.min_visible_fraction)
    groups: dict[int, list[Pair]] = {}
    for pair in pairs:
        groups.setdefault(id(models.info(pair.target)), []).append(pair)
    parts = []
    for mine in groups.values():
        target = mine[0].target
        columns = object_columns(
            mine, predictions, models.info(target), models.points(target), config.fork, standings or Standings()
        )
        lux = illuminance or {}
        parts.append(columns | {"illuminance": [lux.get(pair.place, np.nan) for pair in mine]})
    return table_from_columns(parts)
