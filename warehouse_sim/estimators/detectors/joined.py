"""Detectors that look at the same image: the first is helped by the others."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from warehouse_sim.estimators.api import Detector
from warehouse_sim.estimators.detectors.boxes import Kept, helped
from warehouse_sim.estimators.detectors.estimator import DetectConfig
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.settings import DepthSource
from warehouse_sim.geometry.boxes import mask_box_xyxy

_WEIGHT = 0.4
"""How much a further detector counts beside the first."""
_SAME_OBJECT = 0.5
"""Intersection over union from which on boxes of two detectors are of one object."""


class JoinedDetectors(Detector):
    """Find what the first detector looks for with the help of others.

    Where two find one object, its edges and its score are their weighted mean; what only one finds has half a chance.
    Of the others only what is of a class that the first distinguishes counts.

    Args:
        members: The detectors, the most important one first.
    """

    def __init__(self, members: Sequence[Detector]) -> None:
        self._members = tuple(members)
        self.leave_out_below(DetectConfig.min_score)

    def leave_out_below(self, min_score: float) -> None:
        """Leave out from now on what is found with a joined score below ``min_score`` (0-1)."""
        self._min_score = min_score
        for member in self._members:
            member.leave_out_below(min_score / 2.0)

    @property
    def reads_rgb(self) -> bool:
        """Whether images need colour."""
        return any(member.reads_rgb for member in self._members)

    @property
    def reads_depth(self) -> bool:
        """Whether images need depth, or sweeps."""
        return any(member.reads_depth for member in self._members)

    @property
    def reads_sweep(self) -> bool:
        """Whether one looks at sweeps as they are."""
        return any(member.reads_sweep for member in self._members)

    @property
    def depth_source(self) -> DepthSource:
        """Whose depth the first was made for."""
        return self._members[0].depth_source

    @property
    def classes(self) -> tuple[str, ...]:
        """The classes that the first distinguishes."""
        return self._members[0].classes

    def detect(self, image: RgbdImage) -> list[Detection]:
        """Return what is found, the best first.

        Raises:
            InputError: The image lacks what one of the detectors reads.
        """
        known = self.classes
        found = [
            [item for item in member.detect(image) if item.score > 0.0 and (not known or _name(item) in known)]
            for member in self._members
        ]
        names = {_name(item): number for number, item in enumerate(item for items in found for item in items)}
        kept, items = _kept(found[0], names), found[0]
        for others in found[1:]:
            kept, items = helped(kept, _kept(others, names), _WEIGHT, _SAME_OBJECT), items + others
            items = [items[row] for row in kept.rows]
            kept = kept._replace(rows=np.arange(len(items)))
        return [
            replace(item, box_xyxy=tuple(box), score=float(score))
            for item, box, score in zip(items, kept.boxes.tolist(), kept.scores, strict=True)
            if score > self._min_score
        ]


def _name(item: Detection) -> str | int:
    return item.class_name if item.model is None else item.model


def _kept(found: Sequence[Detection], numbers: dict[str | int, int]) -> Kept:
    return Kept(
        np.array([_box(item) for item in found], dtype=float).reshape(-1, 4),
        np.array([item.score for item in found], dtype=float),
        np.array([numbers[_name(item)] for item in found], dtype=int),
        np.arange(len(found)),
    )


def _box(item: Detection) -> tuple[float, ...]:
    return item.box_xyxy or mask_box_xyxy(np.asarray(item.mask, dtype=bool)) or (0.0, 0.0, 0.0, 0.0)
