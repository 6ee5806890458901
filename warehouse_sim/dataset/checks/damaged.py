"""Check of the surfaces of damaged targets."""

import numpy as np

from warehouse_sim.dataset.checks.findings import Findings
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.damaged_meshes import read_damaged_mesh

_MOST_OUT = 0.03
"""How far (m) boards out of place, and nails, may stand out of the nominal box."""


def damaged_surfaces(subject: Subject) -> Findings:
    """Every damaged object that labels name has its surface, within the box that its pose is of."""
    findings = Findings()
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
    findings.examined = f"{findings.count} surfaces of damaged objects"
    return findings
