"""Checks of the objects that others describe: sizes, units, symmetries."""

import numpy as np
from scipy.spatial import cKDTree

from warehouse_sim.dataset.checks.findings import Findings
from warehouse_sim.dataset.checks.foreign.subject import ForeignSubject
from warehouse_sim.dataset.object_gt import geometry_problems, inside_out
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.geometry.mesh import sample_surface
from warehouse_sim.geometry.pose import transform_points

_DIAMETERS = (0.005, 50.0)
"""Of things that one picks up or drives around (m); a slip of units leaves this range or shows in the images."""
_SAMPLES, _PROBES, _MOST_MOTIONS = 20_000, 500, 16
_SAME_SURFACE = 0.02
"""Mean distance, over the diameter, between a measured surface and itself after a symmetry."""


def objects(subject: ForeignSubject) -> Findings:
    """Hold sizes, diameters and symmetries against the meshes."""
    findings, infos = Findings(), subject.reader.objects
    if not infos or "meshes" in subject.lacks:
        return Findings(lacking="it holds no meshes")
    for info in infos.values():
        where = f"{subject.root}: object {info.obj_id}"
        for problem in (*geometry_problems(info), *inside_out(info, info.mesh())):
            findings.require(False, f"{where}: {problem}")
        low, high = _DIAMETERS
        findings.require(
            low <= info.diameter <= high,
            f"{where}: the diameter is {info.diameter:.6g} m, {low:g} to {high:g} m is plausible; its unit is wrong",
        )
        _symmetries_hold(findings, info, where)
    findings.examined = f"{len(infos)} objects with their meshes"
    return findings


def _symmetries_hold(findings: Findings, info: ObjectInfo, where: str) -> None:
    """Require that a symmetry moves the surface onto itself, as far as a measured one can tell."""
    motions = info.symmetry.transforms
    if len(motions) == 1:
        return
    surface = sample_surface(info.mesh(), _SAMPLES, np.random.default_rng(0))[0]
    tree, probes = cKDTree(surface), surface[:: _SAMPLES // _PROBES]
    step = max((len(motions) - 1) // _MOST_MOTIONS, 1)
    for index in range(1, len(motions), step):
        apart = float(np.mean(tree.query(transform_points(motions[index], probes))[0])) / info.diameter
        same = findings.require(
            apart < _SAME_SURFACE,
            f"{where}: symmetry {index} moves the surface elsewhere, by {100 * apart:.1f} % of the diameter on average",
        )
        if not same:
            return
