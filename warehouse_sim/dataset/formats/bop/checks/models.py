"""Checks of the tables of the BOP models against objects.json and the meshes."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from warehouse_sim.dataset.checks.findings import Findings
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.files.json_file import read_json
from warehouse_sim.dataset.files.plain import take, take_if_given, take_numbers
from warehouse_sim.dataset.formats.bop.layout import BopLayout, bop_layout
from warehouse_sim.dataset.objects import ObjectInfo

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
        axes = [
            take_numbers(axis, "axis", 3, f"{where}: symmetries_continuous")
            for axis in take_if_given(entry, "symmetries_continuous", list, where) or []
        ]
        same_symmetry = _is_group(info, listed, axes)
        findings.require(
            same_symmetry, f"{where}: symmetries_discrete or symmetries_continuous differ from objects.json"
        )


def _is_group(info: ObjectInfo, discrete: Float[np.ndarray, "n 4 4"], axes: Sequence[Float[np.ndarray, " 3"]]) -> bool:
    """Say whether the motions of objects.json are those that are listed, each up to a turn about the axis if one is."""
    motions = info.symmetry.transforms
    if not axes:
        return discrete.shape == motions[1:].shape and np.allclose(discrete, motions[1:], atol=1e-9)
    if len(axes) > 1:
        return False
    along = np.append(axes[0], 0.0)
    listed = np.stack([np.eye(4), *discrete])
    # D^-1 T turns about the axis if both bring it to the same place.
    ends = np.array([[np.allclose(D @ along, T @ along, atol=1e-9) for D in listed] for T in motions])
    return bool((ends.sum(axis=1) == 1).all() and len(set(ends.sum(axis=0).tolist())) == 1)
