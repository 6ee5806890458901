import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.dataset.toy import PALLET
from warehouse_sim.catalog.pallets import pallet
from warehouse_sim.estimators.pose.icp.nearest import VisibleSurfaces
from warehouse_sim.estimators.pose.icp.refine import (
    MAX_DISPLACEMENT,
    MAX_TURN,
    Cloud,
    IcpConfig,
    measure_fit,
    refine_poses,
)
from warehouse_sim.estimators.pose.icp.surface import build_surface
from warehouse_sim.geometry.mesh import TriangleMesh, sample_surface
from warehouse_sim.geometry.pose import invert, make_transform, rotation_angle, rotation_y, rotation_z, transform_points

UPRIGHT = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
MESH = pallet("epal1").mesh()
SURFACE = build_surface(MESH, 20_000, np.random.default_rng(0))


def gt_pose(rng: np.random.Generator) -> np.ndarray:
    turn = rotation_y(rng.uniform(-0.2, 0.2)) @ UPRIGHT @ rotation_z(rng.uniform(0.1, 0.3))
    return make_transform(turn, np.array([rng.uniform(-1, 1), 0.9, rng.uniform(3, 5)]))


def perturbed(T: np.ndarray, rng: np.random.Generator, shift: float, turn: float) -> np.ndarray:
    rotation, translation = (vector / np.linalg.norm(vector) for vector in rng.normal(size=(2, 3)))
    change = make_transform(Rotation.from_rotvec(turn * rotation).as_matrix(), shift * translation)
    return T @ change


def seen(mesh: TriangleMesh, T: np.ndarray, count: int, rng: np.random.Generator, noise: float = 0.0) -> np.ndarray:
    """Points of outer faces turned to the camera, with noise along the rays."""
    points, normals = sample_surface(mesh, 20 * count, rng)
    eye = invert(T)[:3, 3]
    towards = ((eye - points) * normals).sum(axis=1) > 0
    # Only what no other part covers: the nearest CAD sample is on the outer surface.
    free = np.abs(VisibleSurfaces([SURFACE], eye[None], np.ones(1)).nearest(points[None])[0][0]) < 1e-6
    points = transform_points(T, points[towards & free][:count])
    return points * (1.0 + noise * rng.normal(size=(len(points), 1)) / points[:, 2:])


def refine_pose(T: np.ndarray, points: np.ndarray, config: IcpConfig = IcpConfig()) -> np.ndarray:  # noqa: B008
    return refine_poses(T[None], [points], [SURFACE], config)[0]


def add(T_a: np.ndarray, T_b: np.ndarray) -> float:
    points, _ = sample_surface(MESH, 500, np.random.default_rng(9))
    return float(np.linalg.norm(transform_points(T_a, points) - transform_points(T_b, points), axis=1).mean())


def test_recovers_a_known_perturbation_to_2_mm_on_clean_points() -> None:
    rng = np.random.default_rng(0)
    for _ in range(8):
        T = gt_pose(rng)
        start = perturbed(T, rng, 0.03, 0.03)
        result = refine_pose(start, seen(MESH, T, 600, rng))
        assert add(start, T) > 0.015
        assert add(result, T) < 0.002


def test_noise_along_the_rays_does_not_bias_the_depth() -> None:
    rng = np.random.default_rng(1)
    errors, depths = [], []
    for _ in range(12):
        T = gt_pose(rng)
        result = refine_pose(perturbed(T, rng, 0.03, 0.03), seen(MESH, T, 800, rng, 0.03))
        errors.append(add(result, T))
        depths.append(result[2, 3] - T[2, 3])
    assert np.median(errors) < 0.012
    assert abs(np.median(depths)) < 0.008


def test_never_makes_the_fit_worse() -> None:
    rng = np.random.default_rng(2)
    config = IcpConfig()
    for _ in range(10):
        T = gt_pose(rng)
        points = seen(MESH, T, 200, rng, 0.05)
        start = perturbed(T, rng, rng.uniform(0, 0.5), rng.uniform(0, 1.0))
        result = refine_pose(start, points, config)
        moved = np.linalg.norm(result[:3, 3] - start[:3, 3])
        assert moved <= MAX_DISPLACEMENT
        assert rotation_angle(result[:3, :3], start[:3, :3]) <= MAX_TURN
        # Judged under any ratio of errors that the fit may have measured.
        cloud = Cloud.of([points], config.points)
        fits = [
            [
                measure_fit(T[None], cloud, [SURFACE], np.array([anisotropy]), config.max_distance_start)
                for T in (result, start)
            ]
            for anisotropy in (0.1, 0.2, 0.5, 1.0)
        ]
        better = [after.truncated <= before.truncated + 1e-9 for after, before in fits]
        assert any(better)
        assert any(after.trimmed <= before.trimmed + 1e-9 for after, before in fits)


def test_a_batch_gives_what_its_objects_give_alone() -> None:
    rng = np.random.default_rng(5)
    other = build_surface(PALLET.mesh(), 5000, np.random.default_rng(0))
    poses = [gt_pose(rng) for _ in range(4)]
    starts = np.stack([perturbed(T, rng, 0.03, 0.03) for T in poses])
    clouds = [seen(MESH, T, count, rng, 0.01) for T, count in zip(poses, (700, 300, 15, 90), strict=True)]
    surfaces = [SURFACE, other, SURFACE, other]
    together = refine_poses(starts, clouds, surfaces, IcpConfig())
    alone = [
        refine_poses(start[None], [cloud], [surface], IcpConfig())[0]
        for start, cloud, surface in zip(starts, clouds, surfaces, strict=True)
    ]
    np.testing.assert_allclose(together, alone, atol=1e-6)
    assert refine_poses(starts[:0], [], [], IcpConfig()).shape == (0, 4, 4)


def test_the_fit_counts_each_point_up_to_the_gate_and_the_nearest_ones_in_full() -> None:
    T = gt_pose(np.random.default_rng(6))
    points = seen(MESH, T, 10, np.random.default_rng(6))
    points[7:] += [0.0, 0.0, -50.0]
    cloud = Cloud.of([points, points[:7]], 100)
    fit = measure_fit(np.stack([T, T]), cloud, [SURFACE, SURFACE], np.ones(2), 0.1)
    np.testing.assert_allclose(fit.truncated, [0.03, 0.0], atol=1e-6)
    np.testing.assert_allclose(fit.trimmed, [0.0, 0.0], atol=1e-6)


@pytest.mark.parametrize("points", [np.tile([[0.0, 0.0, 9.0]], (50, 1)), np.full((40, 3), 1e3)])
def test_points_that_are_elsewhere_leave_the_pose_alone(points: np.ndarray) -> None:
    T = gt_pose(np.random.default_rng(3))
    np.testing.assert_array_equal(refine_pose(T, points), T)
