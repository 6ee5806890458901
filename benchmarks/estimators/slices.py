"""Docking of a part of the ground truths: by distance, stacks apart, with clearance, where depth failed."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from jaxtyping import Bool

from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.evaluation.error_table import ErrorTable
from warehouse_sim.evaluation.intervals import fraction_interval
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.separation import BoxStack

MARGINS = (0.0, 0.01, 0.02)
"""Clearance beside and above the tines (m)."""
TOUCHING = 0.02
"""Pallets nearer to another than this (m) stand in a stack, or against each other."""
LEAST_READ = 0.25
"""Where less of an amodal mask has a reading, depth has failed, and no estimator is to blame."""
_DRAWS = 1000
_Key = tuple[int, int, int]


def docking_rows(
    table: ErrorTable, reader: DatasetReader, within: tuple[float, float], least_visible: float
) -> list[dict[str, Any]]:
    """Return the docked fractions of every slice that is not empty, with 95 % intervals over scenes.

    Args:
        table: What an estimator did with each ground truth of the test split.
        reader: The dataset.
        within: Distances (m) between which docking is requested.
        least_visible: Least visible fraction of what is counted, 0-1.

    Returns:
        ``slice``, ``margin_mm``, ``value``, ``interval``, ``n`` and ``missed``, the fraction without an estimate.
    """
    table = table.select(table.dockable & (table.visible_fraction >= least_visible))
    found = []
    for name, rows in _slices(table, reader.images("test"), reader, within):
        part = table.select(rows)
        for margin in MARGINS if len(part) else ():
            found.append({"slice": name, "margin_mm": round(1000 * margin), **_fraction(part, margin)})
    return found


def _fraction(table: ErrorTable, margin: float) -> dict[str, Any]:
    docked = table.docks(margin).astype(float)
    low, high = fraction_interval(docked, table.scene_id, _DRAWS, np.random.default_rng(0))
    missed = float((~table.found).mean())
    return {
        "value": round(float(docked.mean()), 5),
        "interval": [round(low, 5), round(high, 5)],
        "n": len(table),
        "missed": round(missed, 5),
    }


def _slices(
    table: ErrorTable, images: Sequence[ImageRecord], reader: DatasetReader, within: tuple[float, float]
) -> Iterator[tuple[str, Bool[np.ndarray, " n"]]]:
    low, high = within
    inside, beyond = (table.distance >= low) & (table.distance < high), table.distance >= high
    stacked, unread = _rows_of(table, touching(images, reader)), _rows_of(table, unread_targets(images))
    yield "all ranges", np.ones(len(table), dtype=bool)
    yield "in range", inside
    yield "in range, alone", inside & ~stacked
    yield "in range, touching", inside & stacked
    yield "beyond, depth read", beyond & ~unread
    yield "beyond, depth failed", beyond & unread


def touching(images: Sequence[ImageRecord], reader: DatasetReader) -> set[_Key]:
    """Return the targets whose box is nearer than ``TOUCHING`` to that of another target of their image."""
    found = set[_Key]()
    for image in images:
        targets = [item for item in image.targets if item.has_pose]
        boxes = [OrientedBox(item.T_camera_object, item.info(reader.objects).size) for item in targets]
        pairs = np.argwhere(np.triu(np.ones((len(boxes), len(boxes)), dtype=bool), 1))
        if len(pairs) == 0:
            continue
        stack = BoxStack.of(boxes)
        for pair in pairs[stack.separation(stack, pairs).distance < TOUCHING]:
            found |= {(image.scene_id, image.image_id, targets[one].gt_index) for one in pair}
    return found


def unread_targets(images: Sequence[ImageRecord]) -> set[_Key]:
    """Return the targets of whose amodal mask less than ``LEAST_READ`` has a depth reading."""
    return {
        (image.scene_id, image.image_id, item.gt_index)
        for image in images
        for item in image.targets
        if item.pixels_valid < LEAST_READ * item.pixels_all
    }


def _rows_of(table: ErrorTable, keys: set[_Key]) -> Bool[np.ndarray, " n"]:
    places = zip(table.scene_id, table.image_id, table.gt_index, strict=True)
    return np.array([tuple(map(int, place)) in keys for place in places], dtype=bool)
