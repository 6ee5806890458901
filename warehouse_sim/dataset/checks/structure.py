"""Checks of what every dataset has: objects and scene records."""

import numpy as np

from warehouse_sim.dataset.checks.findings import Findings, compare_names
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.files.checksums import CHECKSUMS, file_sum, read_checksums
from warehouse_sim.dataset.object_gt import geometry_problems
from warehouse_sim.dataset.stored.readings import read_reading
from warehouse_sim.dataset.stored.scene_record import SceneRecord, read_damaged_mesh
from warehouse_sim.errors import DatasetError
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
