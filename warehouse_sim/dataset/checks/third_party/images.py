"""Checks of the third-party images: whole files, the camera's size, depth that goes with colour."""

import numpy as np
from jaxtyping import Bool

from warehouse_sim.dataset.checks.colour import LEAST_RANK, OF_ANOTHER_PLACE, edge_rank
from warehouse_sim.dataset.checks.findings import Findings
from warehouse_sim.dataset.checks.subject import ThirdPartySubject
from warehouse_sim.dataset.records import ImageRecord, TargetRecord
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.boxes import mask_box_xyxy

_FEW = 20
_MOST_OUTSIDE = 0.1
"""Fraction of a mask that may lie where it must not: others draw masks by hand, or with pixel centres at halves."""
_LEAST_IOU = 0.7
_SAME_COUNT = 0.1
_OFF = 0.75
"""So many boxes that end one pixel too far are a convention and no chance."""


def masks(subject: ThirdPartySubject) -> Findings:
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


def _masks_of(subject: ThirdPartySubject, image: ImageRecord) -> tuple[Findings, list[bool], bool]:
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


_DEPTHS = (0.02, 200.0)
_REGISTERED = 0.72
"""Rank that a quarter of the images must reach: else depth and colour are badly registered, and no image tells."""


def images(subject: ThirdPartySubject) -> Findings:
    """Decode every colour and depth image; a depth image has a plausible unit and its edges where colour has some."""
    findings = Findings()
    seen = {(image.split, image.scene_id, image.image_id): image for image in subject.images}
    ranks: dict[str, float] = {}
    for part, where, rank in subject.each(list(seen.values()), lambda image: _channels(subject, image)):
        findings.add(part)
        ranks |= {} if rank is None else {where: rank}
    registered = bool(ranks) and float(np.quantile(list(ranks.values()), 0.75)) >= _REGISTERED
    without_edges = [where for where, rank in ranks.items() if rank < LEAST_RANK]
    for where in without_edges if registered else ():
        findings.require(False, f"{where}: {OF_ANOTHER_PLACE}")
    no_depth = "; not checked: depth, it holds none" if "depth" in subject.lacks else ""
    off = f"; edges of depth and colour differ in {len(without_edges)}, which was not judged" if without_edges else ""
    findings.examined = f"{findings.count} images{no_depth}{off}"
    return findings


def _channels(subject: ThirdPartySubject, image: ImageRecord) -> tuple[Findings, str, float | None]:
    findings, where = Findings(), subject.where(image)
    rgb = depth = None
    try:
        rgb = None if "colour" in subject.lacks else subject.reader.rgb(image)
        findings.count += rgb is not None
    except DatasetError as problem:
        findings.require(False, str(problem))
    try:
        depth = None if "depth" in subject.lacks else subject.reader.depth(image)
        findings.count += depth is not None
    except DatasetError as problem:
        findings.require(False, str(problem))
    if rgb is not None:
        findings.require(bool(rgb.any()), f"{where}: the colour image holds nothing but zeros")
    if depth is None or not findings.require(bool(depth.any()), f"{where}: the depth image holds nothing but zeros"):
        return findings, where, None
    middle = float(np.median(depth[depth > 0]))
    findings.require(
        _DEPTHS[0] < middle < _DEPTHS[1],
        f"{where}: half of the depth is beyond {middle:.4g} m, {_DEPTHS[0]:g} to {_DEPTHS[1]:g} m is plausible; "
        "its unit or depth_scale is wrong",
    )
    return findings, where, None if rgb is None else edge_rank(rgb, depth)
