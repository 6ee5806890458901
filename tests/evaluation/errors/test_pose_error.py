import numpy as np
import pytest
from scipy.spatial import KDTree
from scipy.spatial.distance import cdist

from tests.evaluation.pallet import CORNERS, SYMMETRY, nudge, random_motion, seen_from, surface
from warehouse_sim.evaluation.errors import pose_error
from warehouse_sim.geometry.pose import make_transform, rotation_x, rotation_z, transform_points
from warehouse_sim.geometry.symmetry import SymmetryGroup

HALF_TURN = make_transform(rotation_z(np.pi))


def symmetric_add(T_estimated, T_gt, symmetry=SYMMETRY):
    return pose_error.add(pose_error.estimates_in_object(T_estimated, T_gt, symmetry), surface()).min(axis=-1)


def symmetric_mssd(T_estimated, T_gt, symmetry=SYMMETRY):
    return pose_error.mssd(pose_error.estimates_in_object(T_estimated, T_gt, symmetry), CORNERS).min(axis=-1)


def legacy_add_s(T_estimated, T_gt):
    return pose_error.add_s(np.linalg.inv(T_gt) @ T_estimated, surface(), KDTree(surface()))


def random_pairs(count: int = 60):
    rng = np.random.default_rng(4)
    true = np.stack([seen_from(rng.uniform(2, 9), rng.uniform(-np.pi, np.pi)) for _ in range(count)])
    estimated = np.stack([T @ random_motion(rng, np.pi if i % 3 == 0 else 0.3, 0.3) for i, T in enumerate(true)])
    return estimated, true


def test_all_errors_vanish_at_the_ground_truth():
    true = seen_from(4.0, 0.4)
    assert symmetric_add(true, true) == pytest.approx(0.0, abs=1e-14)
    assert symmetric_mssd(true, true) == pytest.approx(0.0, abs=1e-14)
    assert legacy_add_s(true, true) == pytest.approx(0.0, abs=1e-14)


def test_a_shift_is_its_own_add_and_mssd_from_any_viewpoint():
    true = np.stack([seen_from(3.0, yaw) for yaw in np.linspace(-3, 3, 7)])
    estimated = make_transform(translation=np.array([0.03, -0.04, 0.12])) @ true
    assert symmetric_add(estimated, true) == pytest.approx(0.13)
    assert symmetric_mssd(estimated, true) == pytest.approx(0.13)


def test_turning_a_pallet_by_a_known_angle_moves_its_corner_along_a_chord():
    angle = np.deg2rad(10.0)
    true = seen_from(5.0)
    chord = 2 * np.sin(angle / 2) * np.hypot(0.6, 0.4)
    assert symmetric_mssd(true @ nudge(yaw=angle), true) == pytest.approx(chord)


def test_errors_are_ordered_add_s_add_mssd():
    estimated, true = random_pairs()
    alone = symmetric_add(estimated, true, SymmetryGroup.trivial())
    assert (legacy_add_s(estimated, true) <= symmetric_add(estimated, true) + 1e-12).all()
    assert (symmetric_add(estimated, true) <= alone + 1e-12).all()
    assert (alone <= symmetric_mssd(estimated, true, SymmetryGroup.trivial()) + 1e-12).all()
    assert (symmetric_mssd(estimated, true) < symmetric_mssd(estimated, true, SymmetryGroup.trivial()) - 0.1).any()


@pytest.mark.parametrize("error", [symmetric_add, symmetric_mssd])
def test_a_symmetric_replacement_of_ground_truth_or_estimate_changes_nothing(error):
    estimated, true = random_pairs()
    expected = error(estimated, true)
    assert error(estimated @ HALF_TURN, true) == pytest.approx(expected, abs=1e-12)
    assert error(estimated, true @ HALF_TURN) == pytest.approx(expected, abs=1e-12)


def test_add_and_mssd_equal_the_definitions_point_by_point():
    estimated, true = random_pairs(8)
    for T_estimated, T_gt in zip(estimated, true, strict=True):
        means, maxima = [], []
        for S in SYMMETRY.transforms:
            guess = surface() @ (T_estimated[:3, :3]).T + T_estimated[:3, 3]
            gt = (surface() @ S[:3, :3].T + S[:3, 3]) @ T_gt[:3, :3].T + T_gt[:3, 3]
            means.append(np.linalg.norm(guess - gt, axis=1).mean())
            maxima.append(np.linalg.norm(guess - gt, axis=1).max())
        assert symmetric_add(T_estimated, T_gt) == pytest.approx(min(means))
        assert symmetric_mssd(T_estimated, T_gt) == pytest.approx(min(maxima))


def test_add_s_measures_from_true_points_to_estimated_points():
    points = np.array([[0.0, 0, 0], [4, 0, 0], [0, 1, 0]])
    T = make_transform(translation=np.array([4.0, 0.0, 0.0]))
    # True points at (0, 0), (4, 0), (0, 1), estimated ones at (4, 0), (8, 0), (4, 1): 4, 0 and 4. The reverse: 0, 4, 1.
    assert pose_error.add_s(T, points, KDTree(points)) == pytest.approx(8 / 3)
    assert pose_error.chamfer(T, points, KDTree(points)) == pytest.approx((8 / 3 + 5 / 3) / 2)
    T = make_transform(translation=np.array([1.0, 0.0, 0.0]))
    skewed = np.array([[0.0, 0, 0], [0.1, 0, 0]])
    # From true to estimated: 1.0 and 0.9; both differ from the mean of the reverse only by which end is nearest.
    assert pose_error.add_s(T, skewed, KDTree(skewed)) == pytest.approx(0.95)


def test_an_upside_down_pallet_fails_add_but_fools_add_s():
    true = seen_from(4.0)
    fallen = true @ make_transform(rotation_x(np.pi))
    assert symmetric_add(fallen, true) > 0.3
    assert legacy_add_s(fallen, true) < 0.02


def test_nearest_symmetry_undoes_the_half_turn_and_gives_rotation_and_translation():
    true = np.stack([seen_from(4.0), seen_from(3.0, 0.5)])
    moved = nudge(x=0.03, y=-0.04, yaw=np.deg2rad(3.0))
    estimated = np.stack([true[0] @ moved, true[1] @ moved @ HALF_TURN])
    best, index = pose_error.nearest_symmetry(pose_error.estimates_in_object(estimated, true, SYMMETRY), CORNERS)
    assert index.tolist() == [0, 1]
    assert np.rad2deg(pose_error.rotation_error(best)) == pytest.approx(3.0)
    assert pose_error.translation_error(best) == pytest.approx(0.05)
    assert best == pytest.approx(np.stack([moved, moved]), abs=1e-12)


def test_many_estimates_at_once_give_what_they_give_one_by_one():
    rng = np.random.default_rng(0)
    T = np.stack([random_motion(rng, 1.0, 0.5) for _ in range(600)])
    assert pose_error.add(T, CORNERS) == pytest.approx([float(pose_error.add(one, CORNERS)) for one in T])


@pytest.mark.parametrize("scale", [0.0, 1e-9, 1e-6, 1e-3, 0.1, 3.0])
def test_add_and_rms_are_those_of_points_that_are_moved_one_by_one(scale: float) -> None:
    rng = np.random.default_rng(3)
    points = rng.uniform(-0.6, 0.6, (400, 3))
    fixed = points[7]
    for turn in (rotation_x(scale * 0.3), rotation_z(scale) @ rotation_x(-0.7 * scale)):
        for t in (scale * rng.normal(size=3), fixed - turn @ fixed):  # the latter leaves one point where it is
            T = make_transform(turn, t)
            distance = np.linalg.norm(points @ turn.T + t - points, axis=1)
            assert pose_error.add(T, points) == pytest.approx(distance.mean(), abs=1e-9 * max(scale, 1e-6), rel=1e-9)
            assert pose_error.surface_rms(T, points) == pytest.approx(
                np.sqrt((distance**2).mean()), abs=1e-11, rel=1e-9
            )


@pytest.mark.parametrize(("angle", "offset"), [(0.05, 0.05), (np.pi, 3.0), (0.0, 300.0)])
def test_add_s_is_what_brute_force_finds(angle: float, offset: float):
    rng = np.random.default_rng(2)
    T, points = np.stack([random_motion(rng, angle, offset) for _ in range(60)]), surface()
    expected = [cdist(points, transform_points(move, points)).min(axis=1).mean() for move in T]
    assert pose_error.add_s(T, points, KDTree(points)) == pytest.approx(np.array(expected), rel=1e-9, abs=1e-12)


def test_chamfer_is_the_mean_of_both_ways():
    rng = np.random.default_rng(5)
    T, points = np.stack([random_motion(rng, 0.3, 0.2) for _ in range(4)]), surface()
    moved = T[:, None, :3, :3] @ points[:, :, None] + T[:, None, :3, 3:]
    apart = np.linalg.norm(moved[..., 0][:, :, None] - points, axis=-1)
    expected = (apart.min(axis=1).mean(axis=1) + apart.min(axis=2).mean(axis=1)) / 2.0
    assert pose_error.chamfer(T, points, KDTree(points)) == pytest.approx(expected)
    assert pose_error.chamfer(HALF_TURN, points, KDTree(points)) == pytest.approx(0.0, abs=1e-12)
