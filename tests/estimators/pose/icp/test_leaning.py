"""Gravity against readings: errors that many readings share tilt nothing, and what truly leans is let lean."""

import numpy as np
import pytest

from warehouse_sim.estimators.pose.fitting.search import COARSE, FINE
from warehouse_sim.estimators.pose.icp.refine import refine_poses
from warehouse_sim.estimators.pose.icp.shared_errors import cells_of, shared
from warehouse_sim.estimators.pose.icp.surface import build_surface
from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.mesh import TriangleMesh, unit_box
from warehouse_sim.geometry.pose import invert, make_transform, matrix_from_quat_wxyz, transform_points

SIZE = np.array([1.2, 0.8, 0.15])
UP = np.array([0.0, -1.0, 0.0])


def upright(distance: float = 2.2, height: float = 0.4) -> np.ndarray:
    """Return a box before a level camera, its long side across and its z axis up."""
    R = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    return make_transform(R, np.array([0.1, height, distance]))


def leaning(T: np.ndarray, angle_deg: float) -> np.ndarray:
    half = np.deg2rad(angle_deg) / 2.0
    turn = matrix_from_quat_wxyz(np.array([np.cos(half), np.sin(half), 0.0, 0.0]))
    return T @ make_transform(turn, np.zeros(3))


def lean_deg(T: np.ndarray) -> float:
    return float(np.degrees(np.arccos(np.clip(T[:3, 2] @ UP, -1.0, 1.0))))


def side(rng: np.random.Generator, count: int, axis: int, sign: float) -> np.ndarray:
    points = rng.uniform(-0.5, 0.5, (count, 3)) * SIZE
    points[:, axis] = sign * SIZE[axis] / 2.0
    return points


def fitted(
    T_gt: np.ndarray,
    points: np.ndarray,
    along_ray: np.ndarray,
    gravity: bool = True,
    start: np.ndarray | None = None,
    grazing: float = 0.0,
) -> np.ndarray:
    """Return the pose found, from upright, of points of the box (object frame) whose ranges err by so much (m)."""
    placed = transform_points(T_gt, points)
    placed = placed * (1.0 + along_ray / np.linalg.norm(placed, axis=1))[:, None]
    placed = placed[np.random.default_rng(5).permutation(len(placed))]
    surface = build_surface(TriangleMesh(box_corners(SIZE), unit_box().faces), 20_000, np.random.default_rng(0))
    T = (upright() if start is None else start)[None]
    # As the search does: coarse steps in which gravity weighs as it is, then ICP.
    for config in (COARSE._replace(rounds=1, iterations=10), FINE):
        T = refine_poses(T, [placed], [surface], config._replace(grazing=grazing), UP if gravity else None)
    return T[0]


@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_a_bias_that_bends_a_front_does_not_tilt_the_object(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = side(rng, 900, 1, -1.0)
    # As of a time-of-flight camera: 6 mm of noise, a front whose foot seems 15 mm farther than its middle.
    foot = np.clip(-points[:, 2] / SIZE[2], 0.0, None) * 2.0
    bias = rng.normal(0.0, 0.006, 900) + 0.015 * foot**2
    assert lean_deg(fitted(upright(), points, bias, gravity=False)) > 2.0
    assert lean_deg(fitted(upright(), points, bias)) < 1.6


@pytest.mark.parametrize("angle_deg", [1.0, 2.0, 3.0, -4.0])
def test_what_leans_beyond_uncertainty_is_found_leaning(angle_deg: float) -> None:
    rng = np.random.default_rng(7)
    points = np.concatenate([side(rng, 400, 1, -1.0), side(rng, 800, 2, 1.0), side(rng, 300, 0, -1.0)])
    gt = leaning(upright(), angle_deg)
    found = fitted(gt, points, rng.normal(0.0, 0.003, len(points)))
    left = invert(gt) @ found
    assert abs(lean_deg(found) - abs(angle_deg)) < 0.2
    assert np.degrees(np.arccos((np.trace(left[:3, :3]) - 1.0) / 2.0)) < 0.5


def test_a_top_that_time_of_flight_reads_too_far_tilts_half_as_much_where_it_is_known() -> None:
    """The farther the flatter it is looked at, 19 to 121 mm, as such a camera was seen to do at 18 degrees."""
    T, believed, with_uncertainty = upright(1.5, 0.55), [], []
    for seed in range(4):
        rng = np.random.default_rng(seed)
        points = np.concatenate([side(rng, 500, 1, -1.0), side(rng, 900, 2, 1.0)])
        on_top = np.arange(1400) >= 500
        bias = rng.normal(0.0, 0.004, 1400) + on_top * (0.019 + 0.102 * (points[:, 1] / SIZE[1] + 0.5))
        believed.append(lean_deg(fitted(T, points, bias, start=T)))
        with_uncertainty.append(lean_deg(fitted(T, points, bias, start=T, grazing=2.0)))
    assert min(believed) > 1.2
    assert np.mean(with_uncertainty) < 0.6 * np.mean(believed)


def test_readings_in_patches_count_as_often_as_there_are_patches() -> None:
    rng = np.random.default_rng(2)
    points = np.concatenate([rng.uniform(-1, 1, (1, 1600, 2)), np.ones((1, 1600, 1))], axis=2)
    present = np.ones((1, 1600), dtype=bool)
    cells = cells_of(points, present)
    np.testing.assert_array_equal(np.bincount(cells[0], minlength=16), np.full(16, 100))
    told = {patches: [] for patches in (16, 64, 1600)}
    for patches, found in told.items():
        across = round(np.sqrt(patches))
        for _ in range(60):
            if patches == 1600:
                residual = rng.normal(0.0, 0.01, 1600)
            else:
                at = ((points[0, :, :2] + 1.0) / 2.0 * (across - 1e-9)).astype(int)
                residual = rng.normal(0.0, 0.01, (across, across))[at[:, 0], at[:, 1]]
            found.append(shared(residual[None], present, cells)[0])
    # The sixteen cells are told of as if a pose had taken six degrees of freedom, which here none has: 15 / 10.
    assert np.mean(told[64]) == pytest.approx(1600 / 64 * 1.5, rel=0.35)
    assert np.mean(told[16]) > 1.5 * np.mean(told[64])
    assert np.mean(told[1600]) == pytest.approx(1.5, rel=0.15)
