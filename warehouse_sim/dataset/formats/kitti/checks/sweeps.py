"""Checks of what goes with the LiDAR points: their ids, rings and times, and the sweeps of further LiDARs."""

from pathlib import Path

import numpy as np
from jaxtyping import Float32

from warehouse_sim.dataset.checks.findings import Findings
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.checks.text import read_bytes
from warehouse_sim.dataset.formats.kitti.checks.frames import frames
from warehouse_sim.dataset.formats.kitti.checks.points import read_points
from warehouse_sim.dataset.formats.kitti.layout import kitti_layout

_FEW_POINTS = 100
"""So few points can lie on one ring, or on surfaces without an id."""
_SPREAD = np.deg2rad(2.0)
"""Elevations of nine tenths of the points of one beam differ by less; rings at all lie farther apart."""


def sweeps(subject: Subject) -> Findings:
    """Points have ids, rings that follow their elevation, and times; so has every further LiDAR, but for its beams."""
    findings, count = Findings(), 0
    for split, scene, _, frame in frames(subject):
        known = {item.instance_id for item in subject.record(scene).objects} | {0}
        for name in ("velodyne", *(f"velodyne_{name}" for name in subject.manifest.contents.lidars)):
            cloud, ids = read_points(subject, split, frame, name)
            path = kitti_layout(subject.root).file(split, f"{name}_ids", frame)
            strange = set(np.unique(ids).tolist()) - known
            findings.require(not strange, f"{path}: names objects that are not in the scene: {sorted(strange)[:5]}")
            findings.require(len(ids) < _FEW_POINTS or bool(ids.any()), f"{path}: holds nothing but zeros")
            finite = np.isfinite(cloud).all() and ((cloud[:, 3] >= 0) & (cloud[:, 3] <= 1)).all()
            place = kitti_layout(subject.root).file(split, name, frame)
            findings.require(bool(finite), f"{place}: a point is not finite, or a reflectance is not in 0-1")
            if name == "velodyne" and finite:
                _beams_follow(findings, kitti_layout(subject.root).file(split, "velodyne_beams", frame), cloud)
            count += 1
    findings.examined = f"{count} sweeps with ids, rings and times"
    return findings


def _beams_follow(findings: Findings, path: Path, cloud: Float32[np.ndarray, "n 4"]) -> None:
    beams = read_bytes(path)
    whole = findings.require(len(beams) == 8 * len(cloud), f"{path}: does not hold a ring and a time of each point")
    if not whole:
        return
    ring, time = np.frombuffer(beams, "<f4").astype(float).reshape(-1, 2).T
    counted = (
        np.isfinite([ring, time]).all() and (ring >= 0).all() and (ring == np.rint(ring)).all() and (time >= 0).all()
    )
    if not findings.require(bool(counted), f"{path}: a ring is no whole number, or a time is negative"):
        return
    if len(cloud) < _FEW_POINTS:
        return
    elevation = np.arctan2(cloud[:, 2], np.hypot(cloud[:, 0], cloud[:, 1]))
    low, high = np.quantile(elevation, [0.05, 0.95])
    if high - low > _SPREAD:
        # Ring 0 is the topmost beam.
        falls = np.ptp(ring) > 0 and np.corrcoef(ring, elevation)[0, 1] < -0.5
        findings.require(bool(falls), f"{path}: rings do not follow the elevation of their points")
    findings.require(bool(np.ptp(time) > 0), f"{path}: all points have the same time")
