"""The LiDAR's points: those of labelled objects lie where beams meet them, and ids, rings and times go with all."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float, Int, Int32

from warehouse_sim.dataset.checks.findings import Findings
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.formats.kitti.checks.frames import (
    LabelRow,
    T_world_image,
    as_measured,
    file_of,
    frames,
    read_camera,
    read_labels,
    read_points,
)
from warehouse_sim.dataset.formats.kitti.checks.labels import tilt
from warehouse_sim.dataset.formats.kitti.checks.lidar_law import FARTHEST_START, SIGMAS, LidarLaw, SweepGrid, in_world
from warehouse_sim.dataset.formats.kitti.external_frame import StoredSweep
from warehouse_sim.dataset.split import Split
from warehouse_sim.dataset.stored.observation_record import RecordedObservation
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.pose import Transform, invert, transform_points

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
            sweep = read_points(subject, split, frame, name)
            ids = np.asarray(sweep.instance_ids)
            path = file_of(subject, split, f"{name}_ids", frame)
            strange = set(np.unique(ids).tolist()) - known
            findings.require(not strange, f"{path}: names objects that are not in the scene: {sorted(strange)[:5]}")
            findings.require(len(ids) < _FEW_POINTS or bool(ids.any()), f"{path}: holds nothing but zeros")
            finite = sweep.dropped == 0 and bool(((sweep.intensity >= 0) & (sweep.intensity <= 1)).all())
            place = file_of(subject, split, name, frame)
            findings.require(finite, f"{place}: a point is not finite, or a reflectance is not in 0-1")
            apart = bool(sweep.points.any(axis=1).all())
            findings.require(apart, f"{place}: a point lies in the sensor's own origin, where nothing is measured")
            if sweep.beams is not None and finite:
                path = file_of(subject, split, "velodyne_beams", frame)
                own = _own_points(subject, (split, scene, observation, frame), sweep.points)
                _beams_follow(findings, path, own, sweep.beams)
            count += 1
    findings.examined = f"{count} sweeps with ids, rings and times"
    return findings


def _own_points(
    subject: Subject, frame: tuple[Split, int, int, int], points: Float[np.ndarray, "n 3"]
) -> Float[np.ndarray, "n 3"]:
    """Return the points of the main LiDAR in its own frame, which its rings and times belong to."""
    split, scene, observation, number = frame
    recorded = subject.record(scene).observations[observation]
    if recorded.T_camera_lidar is None:
        return points
    T_world_points = T_world_image(subject, scene, observation) @ read_camera(subject, split, number)[1]
    return as_measured(points, T_world_points, recorded)


def _beams_follow(
    findings: Findings, path: Path, cloud: Float[np.ndarray, "n 3"], beams: Float[np.ndarray, "n 2"]
) -> None:
    if not findings.require(_are_beams(beams), f"{path}: a ring is no whole number, or a time is negative"):
        return
    ring, time = beams.T.astype(float)
    if len(cloud) < _FEW_POINTS:
        return
    elevation = np.arctan2(cloud[:, 2], np.hypot(cloud[:, 0], cloud[:, 1]))
    low, high = np.quantile(elevation, [0.05, 0.95])
    if high - low > _SPREAD:
        # Ring 0 is the topmost beam.
        falls = np.ptp(ring) > 0 and np.corrcoef(ring, elevation)[0, 1] < -0.5
        findings.require(bool(falls), f"{path}: rings do not follow the elevation of their points")
    findings.require(bool(np.ptp(time) > 0), f"{path}: all points have the same time")


_ROUNDING = 1e-3
"""What files round away of points, labels and calibration (m)."""
_LONGEST_SWEEP = 1e3
_SPREADS = 4.0
"""Standard deviations by which chance may exceed an expected number."""


@dataclass(frozen=True, eq=False)
class _Sweep:
    """A stored sweep and how it was made."""

    path: Path
    stored: StoredSweep
    ids: Int32[np.ndarray, " n"]
    ring: Int[np.ndarray, " n"]
    time: Float[np.ndarray, " n"]
    T_world_lidar: Transform
    """Of the frame that the points are stored in, when the LiDAR looks forward."""
    observation: RecordedObservation
    law: LidarLaw

    @cached_property
    def grid(self) -> SweepGrid:
        """Which beam stands beside which."""
        own = as_measured(self.stored.points, self.T_world_lidar, self.observation)
        return SweepGrid.of(own, self.ids, (self.ring, self.time), self.law)


@dataclass
class _Tally:
    """Points over all sweeps."""

    points: int = 0
    mixed: int = 0
    """Farther off than noise explains, at an edge of the object."""
    alone: int = 0
    """Farther off than noise explains, though all beams around met the object too: what came between is very narrow."""
    least: float = np.inf
    """Least limit of the noise (m)."""
    largest: float = 0.0
    """Largest limit of the noise (m)."""

    def add(self, other: "_Tally") -> None:
        """Count what another tally has counted, too."""
        self.points += other.points
        self.mixed += other.mixed
        self.alone += other.alone
        self.least, self.largest = min(self.least, other.least), max(self.largest, other.largest)


def points(subject: Subject) -> Findings:
    """Points that carry a labelled object's id lie on a beam that meets its 3D box, no farther off than noise explains.

    Where a beam meets an edge, its point can lie between two surfaces: farther off, but on the beam and beside a beam
    that met something else.
    """
    findings, tally, law = Findings(), _Tally(), LidarLaw.of(subject.manifest.contents.lidar)
    sweeps = list(frames(subject))
    for found, counted in subject.each(sweeps, lambda frame: _examine_frame(subject, law, frame)):
        findings.add(found)
        tally.add(counted)
    _judge(findings, tally, law)
    findings.examined = f"{tally.points} points of labelled objects in {len(sweeps)} sweeps" + _describe(tally)
    return findings


def _judge(findings: Findings, tally: _Tally, law: LidarLaw) -> None:
    """Require that points beyond the noise lie at edges, but for those that narrow things between beams explain."""
    beyond, fraction = tally.mixed + tally.alone, law.mixed_fraction / (1.0 + law.mixed_fraction)
    limit = beyond * fraction + _SPREADS * float(np.sqrt(beyond * fraction * (1.0 - fraction)))
    findings.require(
        tally.alone <= limit,
        f"{tally.alone} of {tally.points} points of labelled objects are farther off than noise explains, amid points "
        f"of their own object; mixed beams explain {limit:.0f} of {beyond} points beyond the noise",
    )


def _examine_frame(subject: Subject, law: LidarLaw, frame: tuple[Split, int, int, int]) -> tuple[Findings, _Tally]:
    split, scene, observation, number = frame
    findings, tally = Findings(), _Tally()
    sweep = _read_sweep(subject, law, frame)
    for row in read_labels(subject, split, number):
        box = _box(subject, row, scene, observation)
        if box is not None:
            _examine(findings, tally, sweep, row.instance_id, box)
    return findings, tally


def _read_sweep(subject: Subject, law: LidarLaw, frame: tuple[Split, int, int, int]) -> _Sweep:
    """Read the sweep of a frame.

    Raises:
        DatasetError: A file cannot be read, or a number in it cannot be used.
    """
    split, scene, index, number = frame
    path, stored = file_of(subject, split, "velodyne", number), read_points(subject, split, number)
    if stored.dropped or stored.beams is None or not _are_beams(stored.beams):
        raise DatasetError(f"{path}: points, or rings and times in velodyne_beams, are no finite numbers")
    scan = stored.scan(np.asarray(stored.instance_ids))
    T_world_lidar = T_world_image(subject, scene, index) @ read_camera(subject, split, number)[1]
    observation = subject.record(scene).observations[index]
    ring, time = scan.ring.astype(int), scan.time.astype(float)
    return _Sweep(path, stored, scan.instance_ids, ring, time, T_world_lidar, observation, law)


def _box(
    subject: Subject, row: LabelRow, scene: int, observation: int
) -> tuple[Transform, Float[np.ndarray, " 3"]] | None:
    """Return pose in the world and half sizes of a row's 3D box; of what is DontCare, the scene record has it."""
    record = subject.record(scene)
    item = record.object(row.instance_id)
    if item is None or item.obj_id not in subject.objects:
        return None
    if row.label.is_dont_care:
        return item.T_world_object, np.asarray(subject.objects[item.obj_id].size) / 2.0
    height, breadth, length = row.label.size_hwl
    half = np.array([length, breadth, height]) / 2.0
    T_world_camera = T_world_image(subject, scene, observation)
    # The label stands upright, the object may lean a little.
    lean = np.tan(min(tilt(invert(T_world_camera) @ item.T_world_object), 0.1)) * np.linalg.norm(half)
    return T_world_camera @ row.label.T_camera_object(), half + lean


def _examine(
    findings: Findings,
    tally: _Tally,
    sweep: _Sweep,
    instance_id: int,
    box: tuple[Transform, Float[np.ndarray, " 3"]],
) -> None:
    own, law = np.flatnonzero(sweep.ids == instance_id), sweep.law
    if len(own) == 0:
        return
    points = sweep.stored.points[own].astype(float)
    hits, starts = in_world(points, sweep.time[own], sweep.T_world_lidar, law, sweep.observation)
    T_box_world = invert(box[0])
    start, hit = transform_points(T_box_world, starts), transform_points(T_box_world, hits)
    # How far the place may be off because the time of the forward look is not known exactly.
    turning = abs(sweep.observation.yaw_rate) * np.linalg.norm(points, axis=1)
    half = box[1] + law.time_uncertainty * (np.linalg.norm(sweep.observation.velocity) + turning)[:, None]
    distance = np.maximum(np.linalg.norm(hit - start, axis=1), 1e-6)
    noise = law.noise_limit(distance, sweep.stored.intensity[own].astype(float))
    as_measured = _meets(half, start, hit, distance, noise, law)
    if_mixed = as_measured | _meets(half, start, hit, distance, noise + law.mixing_reach, law)
    wrong = int((~if_mixed).sum())
    findings.require(
        wrong == 0,
        f"{sweep.path}: {wrong} of {len(own)} points of object {instance_id} are outside its box, where neither noise "
        f"({SIGMAS:g} sigma: {noise.max():.3f} m) nor mixed beams put them",
    )
    farther = if_mixed & ~as_measured
    mixed = sweep.grid.beside_another(own[farther], instance_id) if farther.any() else np.zeros(0, bool)
    tally.points += len(own)
    tally.mixed += int(mixed.sum())
    tally.alone += int((~mixed).sum())
    tally.least, tally.largest = min(tally.least, float(noise.min())), max(tally.largest, float(noise.max()))


def _meets(
    half: Float[np.ndarray, "n 3"],
    start: Float[np.ndarray, "n 3"],
    hit: Float[np.ndarray, "n 3"],
    distance: Float[np.ndarray, " n"],
    slack: Float[np.ndarray, " n"],
    law: LidarLaw,
) -> Bool[np.ndarray, " n"]:
    """Return which points, moved along their beams by at most ``slack`` (m), lie in the box (slab test).

    The beam has a width, and its laser may start a little beside the origin of the frame, which turns it a little.
    """
    direction = (hit - start) / distance[:, None]
    aside = law.beam_radius * (distance + slack) + slack * np.minimum(FARTHEST_START / distance, 1.0) + _ROUNDING
    half = half + aside[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = np.stack([(-half - start) / direction, (half - start) / direction])
    enter, leave = np.nanmax(ends.min(axis=0), axis=1), np.nanmin(ends.max(axis=0), axis=1)
    return np.maximum(enter, distance - slack) <= np.minimum(leave, distance + slack)


def _are_beams(beams: Float[np.ndarray, "n 2"]) -> bool:
    """Return whether rings are whole numbers, and neither they nor times are negative or beyond reason."""
    ring, time = beams.T
    whole = (ring >= 0).all() and (ring == np.rint(ring)).all() and (ring < 1e4).all()
    return bool(whole and (time >= 0).all() and (time < _LONGEST_SWEEP).all())


def _describe(tally: _Tally) -> str:
    if not tally.points:
        return ""
    between = tally.mixed + tally.alone
    noise = f"noise of {tally.least:.3f}-{tally.largest:.3f} m allowed along the beam"
    return f"; {noise}, {between} points between two surfaces"
