"""Checks of the third-party images: whole files, the camera's size, depth that goes with colour."""

import numpy as np

from warehouse_sim.dataset.checks.colour import LEAST_RANK, OF_ANOTHER_PLACE, edge_rank
from warehouse_sim.dataset.checks.findings import Findings
from warehouse_sim.dataset.checks.foreign.subject import ForeignSubject
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.errors import DatasetError

_DEPTHS = (0.02, 200.0)
_REGISTERED = 0.72
"""Rank that a quarter of the images must reach: else depth and colour are badly registered, and no image tells."""


def images(subject: ForeignSubject) -> Findings:
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


def _channels(subject: ForeignSubject, image: ImageRecord) -> tuple[Findings, str, float | None]:
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
