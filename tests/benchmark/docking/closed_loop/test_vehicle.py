"""The truck's law and motion against closed forms."""

from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.benchmark.docking.closed_loop import vehicle
from warehouse_sim.benchmark.docking.closed_loop.settings import DRIFTS, DRIVE, Drift
from warehouse_sim.benchmark.docking.closed_loop.vehicle import Motion, Odometry, pursue, slow_down
from warehouse_sim.scene.viewpoints.drives import FloorPose
from warehouse_sim.scene.viewpoints.mountings import FORKLIFT

LAG_FREE = replace(DRIVE, steer_rate=1e3, acceleration=1e3, tick=0.005)


@pytest.mark.parametrize("ahead", [0.4, 0.8])
@pytest.mark.parametrize("aside", [0.01, -0.01])
def test_a_small_offset_decays_as_the_linear_law_says(
    ahead: float, aside: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(vehicle, "DRIVE", replace(LAG_FREE, look_ahead=(ahead, ahead)))
    motion, way = Motion(FloorPose(0.0, aside, 0.0), speed=DRIVE.speed), 0.0
    for _ in range(1500):
        curvature = pursue(10.0, motion.pose.y, motion.pose.yaw)
        motion, step = motion.after(DRIVE.speed, curvature)
        way += step
        # y'' + (2 / L) y' + (2 / L^2) y = 0 with y(0) = aside, y'(0) = 0.
        expected = aside * np.exp(-way / ahead) * (np.cos(way / ahead) + np.sin(way / ahead))
        assert motion.pose.y == pytest.approx(expected, abs=0.01 * abs(aside))


def test_the_arc_of_pursuit_meets_its_point_of_the_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(vehicle, "DRIVE", replace(LAG_FREE, look_ahead=(1.0, 1.0)))
    aside, turned = 0.4, np.deg2rad(-12.0)
    curvature = pursue(10.0, aside, turned)
    radius, start = 1.0 / curvature, FloorPose(0.0, aside, turned)
    centre = np.array([-np.sin(turned), np.cos(turned)]) * radius + [0.0, aside]
    goal = np.array([np.sqrt(1.0 - aside**2), 0.0])
    assert np.linalg.norm(goal - centre) == pytest.approx(abs(radius), rel=1e-9)
    assert np.linalg.norm(goal - [start.x, start.y]) == pytest.approx(1.0)


def test_full_lock_drives_the_least_circle_and_no_smaller_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(vehicle, "DRIVE", LAG_FREE)
    motion = Motion(FloorPose(0.0, 0.0, 0.0), speed=LAG_FREE.speed)
    centre = np.array([0.0, FORKLIFT.min_radius])
    for _ in range(2000):
        motion, _ = motion.after(LAG_FREE.speed, 1e6)
        away = np.linalg.norm([motion.pose.x, motion.pose.y] - centre)
        assert away == pytest.approx(FORKLIFT.min_radius, abs=1e-6)


def test_the_wheel_and_the_speed_follow_no_faster_than_they_can() -> None:
    motion = Motion(FloorPose(0.0, 0.0, 0.0))
    for count in range(1, 5):
        motion, _ = motion.after(10.0, 10.0)
        assert motion.speed == pytest.approx(count * DRIVE.tick * DRIVE.acceleration)
        assert motion.steering == pytest.approx(min(count * DRIVE.tick * DRIVE.steer_rate, np.arctan(1.19 / 0.8)))


def test_braking_stops_within_the_way_that_is_left() -> None:
    motion, left = Motion(FloorPose(0.0, 0.0, 0.0), speed=DRIVE.speed), 1.0
    while motion.speed > 0.02:
        motion, way = motion.after(slow_down(left), 0.0)
        left -= way
        assert left > -0.005


def test_odometry_without_drift_is_the_ground_truth_and_counts_what_the_wheels_do() -> None:
    rng = np.random.default_rng(0)
    start = FloorPose(1.0, 2.0, 0.3)
    true, told = start, Odometry(start, DRIFTS["none"], rng)
    wrong = Odometry(start, Drift(scale=0.0, turn_deg=0.0, noise_deg=0.0), rng)
    wrong.scale = 1.1
    for _ in range(50):
        true = true.after(0.02, 0.7)
        told.add(0.02, 0.7)
        wrong.add(0.02, 0.0)
    assert (told.pose.x, told.pose.y, told.pose.yaw) == pytest.approx((true.x, true.y, true.yaw), abs=1e-12)
    assert np.hypot(wrong.pose.x - 1.0, wrong.pose.y - 2.0) == pytest.approx(1.1)
    assert wrong.pose.yaw == pytest.approx(0.3)


def test_drift_of_heading_grows_as_it_says() -> None:
    ends = []
    for seed in range(400):
        told = Odometry(FloorPose(0.0, 0.0, 0.0), Drift(0.0, 0.5, 0.3), np.random.default_rng(seed))
        for _ in range(40):
            told.add(0.1, 0.0)
        ends.append(told.pose.yaw)
    # 4 m: a steady 0.5 deg a metre and a random 0.3 deg a root of a metre.
    assert np.rad2deg(np.std(ends)) == pytest.approx(np.hypot(0.5 * 4.0, 0.3 * 2.0), rel=0.1)
