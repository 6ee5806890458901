"""Checks of what every dataset has: manifest, objects and scene records."""

from dataclasses import fields

import numpy as np

from warehouse_sim.dataset.checks.findings import Findings, compare_names
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.files.checksums import CHECKSUMS, file_sum, read_checksums
from warehouse_sim.dataset.files.plain import take
from warehouse_sim.dataset.formats import FORMATS
from warehouse_sim.dataset.object_gt import geometry_problems
from warehouse_sim.dataset.split import SPLITS
from warehouse_sim.dataset.stored.readings import read_reading
from warehouse_sim.dataset.stored.recipe_contents import recipe_contents
from warehouse_sim.dataset.stored.scene_record import SceneRecord, read_damaged_mesh
from warehouse_sim.errors import DatasetError, shown
from warehouse_sim.geometry.mesh import diameter

_MOST_OUT = 0.03
"""How far (m) boards out of place, and nails, may stand out of the nominal box."""


def damaged_surfaces(subject: Subject) -> Findings:
    """Every damaged object that labels name has its surface, within the box that its pose is of."""
    findings, listed = Findings(), read_checksums(subject.root)
    for _, scene in subject.scenes():
        for item in subject.record(scene).objects:
            if not item.is_damaged or item.obj_id not in subject.objects:
                continue
            path, mesh = subject.layout.damaged_mesh(item.model), read_damaged_mesh(subject.root, item)
            findings.require(mesh is not None, f"{path}: is missing, scene {scene} names it")
            findings.count += 1
            if mesh is None:
                continue
            out = float((np.abs(mesh.vertices).max(axis=0) - subject.info(item.obj_id).size / 2).max())
            findings.require(out <= _MOST_OUT, f"{path}: stands out of its object's box by {out:.3f} m")
            same = listed is None or listed.get(path.relative_to(subject.root).as_posix()) == file_sum(path)
            findings.require(same, f"{path}: is not the file that {CHECKSUMS} lists")
    findings.examined = f"{findings.count} surfaces of damaged objects"
    return findings


def readings(subject: Subject) -> Findings:
    """Each sensor of the manifest, and no other, has a file an observation with the arrays that the manifest says."""
    findings, sensors = Findings(), subject.manifest.contents.readings
    compare_names(findings, subject.layout.readings, set(sensors), "sensor")
    places = list(subject.observations())
    names = {subject.layout.reading("any", scene, observation).name for _, scene, observation in places}
    for name, contents in sensors.items():
        compare_names(findings, subject.layout.readings / name, names)
        for _, scene, observation in places:
            path = subject.layout.reading(name, scene, observation)
            try:
                read_reading(path, contents)
            except DatasetError as problem:
                findings.require(False, str(problem))
            findings.count += 1
    findings.examined = f"{findings.count} readings of {', '.join(sensors)}"
    return findings


_SAME_LENGTH = 1e-6
"""How far (m) a diameter or a distance may be off."""


def objects(subject: Subject) -> Findings:
    """Hold objects.json against the meshes, where a format has any."""
    infos = subject.objects
    findings = Findings(f"{len(infos)} objects")
    for info in (item for item in infos.values() if item.read_mesh is not None):
        for problem in geometry_problems(info):
            findings.require(False, f"{subject.layout.objects}: {info.obj_id}: {problem}")
        measured = diameter(info.mesh().vertices)
        findings.require(
            abs(measured - info.diameter) < _SAME_LENGTH,
            f"{subject.layout.objects}: {info.obj_id}: diameter is {info.diameter:.6f} m, "
            f"the mesh has {measured:.6f} m",
        )
    return findings


def scenes(subject: Subject) -> Findings:
    """Each scene has one record, of the right split, with every observation and unique instance ids."""
    findings = Findings(f"{len(subject.manifest.scene_indices)} scene records")
    kinds = {info.name: (info.class_name, number) for number, info in subject.objects.items()}
    compare_names(findings, subject.layout.scenes, {f"{index:06d}.json" for _, index in subject.scenes()})
    for split, index in subject.scenes():
        record, where = subject.record(index), str(subject.layout.scene_record(index))
        findings.require(
            (record.scene_index, record.split, record.seed) == (index, split, subject.manifest.seed),
            f"{where}: says scene {record.scene_index} of {record.split}, seed {record.seed}; "
            f"the manifest says scene {index} of {split}, seed {subject.manifest.seed}",
        )
        findings.require(
            len(record.T_world_camera) == subject.manifest.observations_per_scene,
            f"{where}: {len(record.T_world_camera)} observations instead of {subject.manifest.observations_per_scene}",
        )
        ids = [item.instance_id for item in record.objects]
        findings.require(len(set(ids)) == len(ids) and min(ids, default=1) >= 1, f"{where}: instance ids repeat")
        _same_kinds(findings, record, where, kinds)
        _measured_targets(findings, record, where)
        findings.require(record.renderer in subject.manifest.renderers, f"{where}: its renderer is not in the manifest")
    return findings


def _same_kinds(findings: Findings, record: SceneRecord, where: str, kinds: dict[str, tuple[str, int]]) -> None:
    """Hold class and number of each object against those that its model has elsewhere; new models are added."""
    for item in record.objects:
        class_name, number = kinds.setdefault(item.model, (item.class_name, item.obj_id))
        findings.require(
            (item.class_name, item.obj_id) == (class_name, number),
            f"{where}: {item.model} is {item.class_name!r}, {item.obj_id}, elsewhere {class_name!r}, {number}",
        )


def _measured_targets(findings: Findings, record: SceneRecord, where: str) -> None:
    """Hold what a record says of each observation's targets against its own objects and cameras."""
    for index, observation in enumerate(record.observations):
        for target in observation.targets:
            item, here = record.object(target.instance_id), f"{where}: observation {index}: {target.instance_id}"
            if not findings.require(item is not None, f"{here}: is no object of the scene"):
                continue
            assert item is not None
            apart = float(np.linalg.norm(item.T_world_object[:3, 3] - observation.T_world_camera[:3, 3]))
            findings.require(
                abs(apart - target.distance) < _SAME_LENGTH,
                f"{here}: distance is {target.distance:.6g} m, camera and object are {apart:.6g} m apart",
            )


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
