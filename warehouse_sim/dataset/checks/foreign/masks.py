"""Checks of the masks made by third parties, against each other, their boxes and their counts."""

import numpy as np
from jaxtyping import Bool

from warehouse_sim.dataset.checks.findings import Findings
from warehouse_sim.dataset.checks.foreign.subject import ForeignSubject
from warehouse_sim.dataset.records import ImageRecord, TargetRecord
from warehouse_sim.geometry.boxes import mask_box_xyxy

_FEW = 20
_MOST_OUTSIDE = 0.1
"""Fraction of a mask that may lie where it must not: others draw masks by hand, or with pixel centres at halves."""
_LEAST_IOU = 0.7
_SAME_COUNT = 0.1
_OFF = 0.75
"""So many boxes that end one pixel too far are a convention and no chance."""


def masks(subject: ForeignSubject) -> Findings:
    """Look whether visible masks lie in amodal masks, do not overlap, and have the boxes and counts of their labels."""
    if "masks" in subject.lacks:
        return Findings(lacking="it holds no masks")
    findings, real = Findings(), False
    beyond: list[bool] = []
    images = [image for image in subject.images if image.targets]
    parts = []
    for part, ends, has_shape in subject.each(images, lambda image: _masks_of(subject, image)):
        parts.append(part)
        beyond += ends
        real |= has_shape
    # What is wrong everywhere comes first: it explains the rest.
    if len(beyond) >= 3 and np.mean(beyond) > _OFF:
        findings.require(
            False,
            f"{subject.root}: {100 * np.mean(beyond):.0f} % of {len(beyond)} visible boxes end one pixel behind their "
            "masks; BOP's width is xmax - xmin, without COCO's one more",
        )
    for part in parts:
        findings.add(part)
    if not findings.count:
        return Findings(lacking="it holds no labels")
    if not real and not findings.problems:
        return Findings(lacking="it holds no masks; the boxes of its labels stand for them")
    findings.examined = f"{findings.count} masks with their boxes"
    return findings


def _masks_of(subject: ForeignSubject, image: ImageRecord) -> tuple[Findings, list[bool], bool]:
    """Return problems, whether each box ends one pixel too far, and whether any mask is more than a full box."""
    findings, ends, real = Findings(), [], False
    taken = np.zeros((image.camera.height, image.camera.width), dtype=bool)
    for target in image.targets:
        where = f"{subject.where(image)}, mask of target {target.gt_index}"
        visible = subject.reader.mask_visible(image, target.gt_index)
        whole = subject.reader.mask(image, target.gt_index)
        count, box = int(np.count_nonzero(visible)), mask_box_xyxy(visible)
        findings.count += 1
        _count_agrees(findings, target, count, where)
        if box is None or count < _FEW:
            continue
        full = (box[2] - box[0] + 1) * (box[3] - box[1] + 1)
        shaped = count < full
        real |= shaped
        exact = shaped and "ground-truth masks" not in subject.lacks
        _lies_well(findings, visible, whole, taken, exact, where)
        taken |= visible
        ends.append(_box_agrees(findings, target, box, where))
    return findings, ends, real


def _count_agrees(findings: Findings, target: TargetRecord, count: int, where: str) -> None:
    same = abs(count - target.pixels_visible) <= _SAME_COUNT * max(count, target.pixels_visible) + _FEW
    findings.require(same, f"{where}: has {count} pixels, its label says {target.pixels_visible}")


def _lies_well(
    findings: Findings,
    visible: Bool[np.ndarray, "h w"],
    whole: Bool[np.ndarray, "h w"],
    taken: Bool[np.ndarray, "h w"],
    exact: bool,
    where: str,
) -> None:
    count = np.count_nonzero(visible)
    outside = np.count_nonzero(visible & ~whole) / count
    findings.require(
        bool(outside < _MOST_OUTSIDE), f"{where}: {100 * outside:.0f} % of it lie outside its whole amodal mask"
    )
    shared = np.count_nonzero(visible & taken) / count
    # Boxes that stand for masks overlap as they like, and polygons bridge the parts of what is covered.
    findings.require(
        not exact or bool(shared < _MOST_OUTSIDE), f"{where}: {100 * shared:.0f} % of it belong to other objects, too"
    )


def _box_agrees(findings: Findings, target: TargetRecord, box: tuple[int, int, int, int], where: str) -> bool:
    """Require that the box of the visible part is that of the mask; return whether it ends one pixel too far."""
    stored, found = np.array(target.box_visible_xyxy), np.array(box, dtype=float)
    low, high = np.maximum(stored[:2], found[:2]), np.minimum(stored[2:], found[2:])
    both = float(np.prod(np.maximum(high - low + 1.0, 0.0)))
    areas = [float(np.prod(item[2:] - item[:2] + 1.0)) for item in (stored, found)]
    fraction = both / max(sum(areas) - both, 1e-9)
    findings.require(fraction > _LEAST_IOU, f"{where}: bbox_visib is {stored.tolist()}, the mask has {found.tolist()}")
    return bool((stored[:2] == found[:2]).all() and (stored[2:] == found[2:] + 1.0).all())
