"""Say of a dataset folder, check by check, whether it can be trusted."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

from warehouse_sim.dataset.checks import (
    agreement,
    bop_images,
    bop_tables,
    cameras,
    kitti,
    kitti_labels,
    kitti_points,
    manifest,
    poses,
    structure,
    sweeps,
)
from warehouse_sim.dataset.checks.subject import Check, Findings, Subject
from warehouse_sim.dataset.manifest import read_manifest
from warehouse_sim.errors import WarehouseSimError

__all__ = ["Check", "validate"]

ProgressCallback = Callable[[float, str], None]
"""Called with the share of the work that is done (0-1) and the name of the check that runs."""
_CHECKS: tuple[tuple[str, frozenset[str], Callable[[Subject], Findings]], ...] = (
    ("manifest", frozenset(), manifest.contents),
    ("objects", frozenset(), structure.objects),
    ("scene records", frozenset(), structure.scenes),
    ("bop files", frozenset({"bop"}), bop_tables.files),
    ("bop tables", frozenset({"bop"}), bop_tables.tables),
    ("bop cameras", frozenset({"bop"}), cameras.bop),
    ("bop coco", frozenset({"bop"}), bop_tables.coco),
    ("bop targets", frozenset({"bop"}), bop_tables.targets),
    ("bop images", frozenset({"bop"}), bop_images.images),
    ("bop masks", frozenset({"bop"}), bop_images.masks),
    ("bop poses on images", frozenset({"bop"}), poses.projection),
    ("kitti files", frozenset({"kitti"}), kitti.files),
    ("kitti labels", frozenset({"kitti"}), kitti_labels.labels),
    ("kitti calib", frozenset({"kitti"}), kitti.calib),
    ("kitti images", frozenset({"kitti"}), kitti.images),
    ("kitti points in boxes", frozenset({"kitti"}), kitti_points.points),
    ("kitti sweeps", frozenset({"kitti"}), sweeps.sweeps),
    ("kitti and bop labels", frozenset({"kitti", "bop"}), agreement.labels),
    ("kitti and bop cameras", frozenset({"kitti", "bop"}), agreement.cameras),
    ("kitti and bop images", frozenset({"kitti", "bop"}), agreement.images),
)
"""Name, formats that a dataset must have for it, and the function."""


def validate(root: Path, progress: ProgressCallback = lambda share, note: None) -> list[Check]:
    """Check a dataset folder from its manifest down to single pixels.

    Args:
        root: Folder of the dataset.
        progress: Told how far the checks are.

    Returns:
        One entry a check; only the first one where the manifest cannot be read or speaks of another folder.
    """
    try:
        subject = Subject(root, read_manifest(root))
        manifest.require_size(subject)
    except WarehouseSimError as problem:
        return [Check("manifest", False, str(problem))]
    stored = set(subject.manifest.formats)
    asked = [(name, function) for name, formats, function in _CHECKS if formats <= stored]
    checks = []
    for number, (name, function) in enumerate(asked):
        subject.progress = partial(_tell, progress, name, number, len(asked))
        subject.progress(0.0)
        checks.append(_run(name, function, subject))
    progress(1.0, f"{len(checks)} checks")
    return checks


def _tell(progress: ProgressCallback, name: str, number: int, count: int, share: float) -> None:
    """Tell that a share of check ``number`` of ``count`` is done."""
    progress((number + share) / count, name)


def _run(name: str, function: Callable[[Subject], Findings], subject: Subject) -> Check:
    """Run one check; what it cannot read is a failure of this check, and the others still run."""
    try:
        findings = function(subject)
    except WarehouseSimError as problem:
        return Check(name, False, str(problem))
    if not findings.problems:
        return Check(name, True, findings.examined)
    others = len(findings.problems) - 1 + findings.more
    more = f" (and {others} more)" if others else ""
    return Check(name, False, findings.problems[0] + more)
