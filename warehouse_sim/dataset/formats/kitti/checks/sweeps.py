"""Checks of what goes with the LiDAR points: their ids, rings and times, and the sweeps of further LiDARs."""

from pathlib import Path

import numpy as np
from jaxtyping import Float, Float32

from warehouse_sim.dataset.checks.findings import Findings, read_bytes, read_text
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.formats.kitti.checks.frames import T_world_image, frames
from warehouse_sim.dataset.formats.kitti.checks.points import read_points
from warehouse_sim.dataset.formats.kitti.checks.sensor_frame import as_measured
from warehouse_sim.dataset.formats.kitti.layout import kitti_layout
from warehouse_sim.dataset.formats.kitti.reader import parse_calib
from warehouse_sim.dataset.split import Split
from warehouse_sim.geometry.pose import make_transform

_FEW_POINTS = 100
"""So few points can lie on one ring, or on surfaces without an id."""
_SPREAD = np.deg2rad(2.0)
"""Elevations of nine tenths of the points of one beam differ by less; rings at all lie farther apart."""


def sweeps(subject: Subject) -> Findings:
    """Points have ids, rings that follow their elevation, and times; so has every further LiDAR, but for its beams."""
    findings, count = Findings(), 0
    for split, scene, observation, frame in frames(subject):
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
            apart = bool(cloud[:, :3].any(axis=1).all())
            findings.require(apart, f"{place}: a point lies in the sensor's own origin, where nothing is measured")
            if name == "velodyne" and finite:
                path = kitti_layout(subject.root).file(split, "velodyne_beams", frame)
                _beams_follow(findings, path, _own_points(subject, (split, scene, observation, frame), cloud))
            count += 1
    findings.examined = f"{count} sweeps with ids, rings and times"
    return findings


def _own_points(
    subject: Subject, frame: tuple[Split, int, int, int], cloud: Float32[np.ndarray, "n 4"]
) -> Float[np.ndarray, "n 3"]:
    """Return the points of the main LiDAR in its own frame, which its rings and times belong to."""
    split, scene, observation, number = frame
    recorded = subject.record(scene).observations[observation]
    if recorded.T_camera_lidar is None:
        return cloud[:, :3]
    path = kitti_layout(subject.root).file(split, "calib", number)
    matrix = parse_calib(read_text(path), str(path))["Tr_velo_to_cam"]
    T_world_points = T_world_image(subject, scene, observation) @ make_transform(matrix[:, :3], matrix[:, 3])
    return as_measured(cloud[:, :3], T_world_points, recorded)


def _beams_follow(findings: Findings, path: Path, cloud: Float[np.ndarray, "n 3"]) -> None:
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
