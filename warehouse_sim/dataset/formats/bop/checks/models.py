"""Checks of the tables of the BOP models against objects.json and the meshes."""

import numpy as np

from warehouse_sim.dataset.checks.findings import Findings
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.formats.bop.layout import BopLayout, bop_layout
from warehouse_sim.dataset.json_file import read_json
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.plain import take, take_if_given, take_numbers

_MILLIMETRE_DIGITS = 1e-3


def models(subject: Subject) -> Findings:
    """Sizes, diameters and symmetries of both tables are those of the meshes and of objects.json."""
    findings = Findings(f"{len(subject.objects)} models of two kinds")
    for info in subject.objects.values():
        _agree(findings, bop_layout(subject.root), info)
    return findings


def _agree(findings: Findings, bop: BopLayout, info: ObjectInfo) -> None:
    for kind, mesh in (("models", info.mesh()), ("models_eval", info.metric_mesh())):
        path = bop.models_info(kind)
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
