"""Checks of the manifest against what the package knows and what the folder holds."""

from dataclasses import fields

from warehouse_sim.dataset.checks.findings import Findings
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.files.plain import take
from warehouse_sim.dataset.formats import FORMATS
from warehouse_sim.dataset.split import SPLITS
from warehouse_sim.dataset.stored.recipe_contents import recipe_contents
from warehouse_sim.errors import DatasetError, shown

_NOT_IN_RECIPE = ("plugins", "readings", "levelled", "view_angle_deg")
"""Contents that are known later than the recipe, or with the catalog."""


def contents(subject: Subject) -> Findings:
    """Check that formats and targets are known, that the recipe is recorded, and that the split table is counted right.

    Raises:
        DatasetError: The recipe's sensors or the split table are malformed.
    """
    manifest = subject.manifest
    splits = ", ".join(f"{name} {len(scenes)}" for name, scenes in manifest.splits.items())
    missing = f"; {len(manifest.missing)} could not be made and are missing" if manifest.missing else ""
    findings = Findings(f"{manifest.scenes} scenes ({splits}), disjoint by scene{missing}")
    _known_formats(findings, subject)
    _own_targets(findings, subject)
    if not manifest.converted_from:
        findings.require(
            bool(manifest.recipe), f"{subject.layout.manifest}: recipe is empty; nobody can make this again"
        )
        _of_recipe(findings, subject)
    _split_table(findings, subject)
    return findings


def require_size(subject: Subject) -> None:
    """Reject a manifest that says another number of observations than its first scene's record.

    Nearly every file would be reported missing.

    Raises:
        DatasetError: The numbers differ.
    """
    index = min(index for _, index in subject.scenes())
    try:
        found = len(subject.record(index).observations)
    except DatasetError:
        # The check of the records reports an unreadable one.
        return
    if found != subject.manifest.observations_per_scene:
        raise DatasetError(
            f"{subject.layout.manifest}: observations_per_scene is {subject.manifest.observations_per_scene}, "
            f"{subject.layout.scene_record(index)} has {found}; copy or generate the dataset again"
        )


def _known_formats(findings: Findings, subject: Subject) -> None:
    formats, known = subject.manifest.formats, FORMATS.names()
    where = f"{subject.layout.manifest}: formats"
    findings.require(bool(formats) and len(set(formats)) == len(formats), f"{where}: must name formats, each once")
    for name in formats:
        findings.require(
            name in known,
            f"{where}: unknown dataset format {shown(name)}; known: {', '.join(known)}; "
            "install the package that adds it",
        )
    for name in sorted(set(known) - set(formats)):
        findings.require(not (subject.root / name).exists(), f"{where}: lack {name}, whose folder is there")


def _own_targets(findings: Findings, subject: Subject) -> None:
    where = f"{subject.layout.manifest}: targets"
    targets, classes = set(subject.manifest.targets), {info.class_name for info in subject.objects.values()}
    for name in sorted(classes - targets):
        findings.require(False, f"{where}: lack the class {name} of an object in {subject.layout.objects}")
    # A recipe can require a class of which it then places nothing.
    requested = subject.manifest.contents.targets
    allowed = classes if requested is None else requested
    for name in sorted(targets):
        findings.require(name in allowed, f"{where}: {shown(name)} is no class of the recipe or of the objects")


def _of_recipe(findings: Findings, subject: Subject) -> None:
    """Require that the contents are those that the recipe describes."""
    manifest, where = subject.manifest, subject.layout.manifest
    described, found = recipe_contents(manifest.recipe, f"{where}: recipe"), manifest.contents
    for key in (item.name for item in fields(found) if item.name not in _NOT_IN_RECIPE):
        same = getattr(described, key) == getattr(found, key)
        findings.require(same, f"{where}: contents: {key} is {shown(getattr(found, key))}, which is not the recipe's")


def _split_table(findings: Findings, subject: Subject) -> None:
    table, where = subject.manifest.split_table, f"{subject.layout.manifest}: split_table"
    for split in SPLITS:
        row = take(table, split, dict, where)
        scenes = [subject.record(index) for index in subject.manifest.splits[split]]
        observations = [item for scene in scenes for item in scene.observations]
        counts = {
            "scenes": len(scenes),
            "observations": len(observations),
            "targets": sum(len(item.targets) for item in observations),
        }
        for key, count in counts.items():
            found = take(row, key, int, f"{where}: {split}")
            findings.require(found == count, f"{where}: {split}: {key} is {found}, the scene records have {count}")
