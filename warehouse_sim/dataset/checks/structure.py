"""Checks of what every dataset has: objects and scene records."""

import numpy as np

from warehouse_sim.dataset.checks.subject import Findings, Subject, compare_names
from warehouse_sim.dataset.json_file import read_json
from warehouse_sim.dataset.object_truth import untruths
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.plain import take, take_if_given, take_numbers
from warehouse_sim.geometry.mesh import diameter

_MILLIMETRE_DIGITS = 1e-3


def objects(subject: Subject) -> Findings:
    """Hold objects.json against the meshes, and the tables of the BOP models against both."""
    infos = subject.objects
    findings = Findings(f"{len(infos)} objects")
    for info in infos.values():
        if "bop" in subject.manifest.formats:
            for problem in untruths(info):
                findings.require(False, f"{subject.layout.objects}: {info.obj_id}: {problem}")
            _models_agree(findings, subject, info)
    return findings


def scenes(subject: Subject) -> Findings:
    """Each scene has one record, of the right split, with every observation and unique instance ids."""
    findings = Findings(f"{subject.manifest.scenes} scene records")
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
        findings.require(record.renderer in subject.manifest.renderers, f"{where}: its renderer is not in the manifest")
    return findings


def _models_agree(findings: Findings, subject: Subject, info: ObjectInfo) -> None:
    measured = diameter(info.mesh().vertices)
    findings.require(
        abs(measured - info.diameter) < _MILLIMETRE_DIGITS / 1000.0,
        f"{subject.layout.objects}: {info.obj_id}: diameter is {info.diameter:.6f} m, the mesh has {measured:.6f} m",
    )
    for kind, mesh in (("models", info.mesh()), ("models_eval", info.metric_mesh())):
        path = subject.bop.models_info(kind)
        where = f"{path}: {info.obj_id}"
        entry = take(read_json(path), str(info.obj_id), dict, str(path))
        low = np.array([take(entry, f"min_{axis}", float, where) for axis in "xyz"])
        size = np.array([take(entry, f"size_{axis}", float, where) for axis in "xyz"])
        points_mm = mesh.vertices * 1000.0
        same_box = np.abs([low - points_mm.min(axis=0), low + size - points_mm.max(axis=0)]).max() < _MILLIMETRE_DIGITS
        findings.require(bool(same_box), f"{where}: min and size are not those of the mesh")
        largest = take(entry, "diameter", float, where)
        same_diameter = abs(largest - info.diameter * 1000.0) < _MILLIMETRE_DIGITS
        findings.require(same_diameter, f"{where}: diameter {largest:.4f} mm is not that of objects.json")
        rows = take_if_given(entry, "symmetries_discrete", list, where) or []
        motions = {str(i): row for i, row in enumerate(rows)}
        numbers = [take_numbers(motions, key, 16, f"{where}: symmetries_discrete") for key in motions]
        listed = np.reshape(numbers, (-1, 4, 4))
        listed[:, :3, 3] /= 1000.0
        same_symmetry = listed.shape == info.symmetry.transforms[1:].shape and np.allclose(
            listed, info.symmetry.transforms[1:], atol=1e-9
        )
        findings.require(same_symmetry, f"{where}: symmetries_discrete differ from objects.json")
