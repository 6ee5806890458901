"""Say of a dataset folder, check by check, whether it can be trusted."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from warehouse_sim.dataset.checks import structure
from warehouse_sim.dataset.checks.findings import Check, Findings, NamedCheck
from warehouse_sim.dataset.checks.subject import Subject, ThirdPartySubject
from warehouse_sim.dataset.checks.third_party import checks_of
from warehouse_sim.dataset.formats import FORMATS, dataset_format
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.manifest import read_manifest
from warehouse_sim.dataset.reader import is_dataset
from warehouse_sim.errors import WarehouseSimError

__all__ = ["Check", "validate"]

ProgressCallback = Callable[[float, str], None]
"""Called with the fraction of the work that is done (0-1) and the name of the check that runs."""
_CHECKS = (
    NamedCheck("manifest", structure.contents),
    NamedCheck("objects", structure.objects),
    NamedCheck("scene records", structure.scenes),
)
"""What is requested of every dataset, whatever its formats."""


def validate(root: str | Path, progress: ProgressCallback = lambda fraction, note: None) -> list[Check]:
    """Check a dataset folder from its manifest down to single pixels; of one made by third parties, what it holds.

    Args:
        root: Folder of the dataset.
        progress: Called with how far the checks are.

    Returns:
        One entry a check; only the first one where the manifest cannot be read or speaks of another folder.
    """
    root = Path(root)
    try:
        requested = requested_checks(root)
    except WarehouseSimError as problem:
        if not DatasetLayout(root).manifest.is_file() and is_dataset(root):
            raise
        return [Check("manifest", False, str(problem))]
    checks: list[Check] = []
    for number, (check, seen) in enumerate(requested):
        seen.progress = partial(_report_progress, progress, check.name, number, len(requested))
        seen.progress(0.0)
        found = run_check(check, seen)
        checks.append(_once(found, checks) if isinstance(seen, ThirdPartySubject) else found)
    progress(1.0, f"{len(checks)} checks")
    return checks


def requested_checks(root: Path) -> list[tuple[NamedCheck, Subject | ThirdPartySubject]]:
    """Return the checks of a dataset in their order, each with the dataset as it is to see it.

    Raises:
        WarehouseSimError: The manifest cannot be read or speaks of another folder.
    """
    if not DatasetLayout(root).manifest.is_file() and is_dataset(root):
        others = ThirdPartySubject.of(root)
        return [(check, others) for check in checks_of(others)]
    subject = Subject(root, read_manifest(root))
    structure.require_size(subject)
    return [(check, subject if name is None else subject.of_format(name)) for check, name in _requested(subject)]


def _requested(subject: Subject) -> list[tuple[NamedCheck, str | None]]:
    """Return the checks of the dataset, each with the format whose files it looks at, if it is one format's."""
    stored = set(subject.manifest.formats) & set(FORMATS.names())
    requested: list[tuple[NamedCheck, str | None]] = [(check, None) for check in _CHECKS]
    if subject.manifest.contents.readings or subject.layout.readings.exists():
        requested.append((NamedCheck("readings", structure.readings), None))
    if subject.layout.damaged.exists():
        requested.append((NamedCheck("damaged surfaces", structure.damaged_surfaces), None))
    for name in sorted(stored):
        checks = dataset_format(name).checks
        requested += [(check, name) for check in checks if check.compares_with is None or check.compares_with in stored]
    return requested


def _once(found: Check, earlier: Sequence[Check]) -> Check:
    """Return an outcome; what stops all checks of third-party images, such as a lost table, is said once."""
    same = next((item.name for item in earlier if not item.ok and item.detail == found.detail), None)
    return found if same is None else Findings(lacking=f"what {same} found stops it").outcome(found.name)


def _report_progress(progress: ProgressCallback, name: str, number: int, count: int, fraction: float) -> None:
    """Report that a fraction of check ``number`` of ``count`` is done."""
    progress((number + fraction) / count, name)


def run_check(check: NamedCheck, subject: Subject | ThirdPartySubject) -> Check:
    """Run one check; what it cannot read is a failure of this check, and the others still run."""
    if isinstance(subject, Subject) and (lacked := check.lacks(subject.manifest.contents.outputs)):
        return Findings(lacking=f"{lacked} is left out").outcome(check.name)
    try:
        return check.run(subject).outcome(check.name)
    except WarehouseSimError as problem:
        return Check(check.name, False, str(problem))
