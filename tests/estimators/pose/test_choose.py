import numpy as np
import pytest

from warehouse_sim.estimators.pose.choose import Candidates, Selection, Symmetries, select_poses
from warehouse_sim.geometry.pose import (
    make_transform,
    matrix_from_quat_wxyz,
    quat_wxyz_from_matrix,
    rotation_angle,
    rotation_x,
    rotation_z,
)
from warehouse_sim.geometry.symmetry import SymmetryGroup

C2 = SymmetryGroup.turns("z", 2)
ALONE = SymmetryGroup.trivial()
AVERAGES = ["weighted", "weighted-50", "consensus"]


def select(
    rotations: list[np.ndarray],
    confidences: np.ndarray,
    method: Selection,
    group: SymmetryGroup = C2,
    translations: np.ndarray | None = None,
) -> np.ndarray:
    """Select for one object."""
    quat = np.stack([quat_wxyz_from_matrix(rotation) for rotation in rotations])
    quat[::2] *= -1.0  # the sign of a quaternion means nothing
    places = np.tile([0.5, -0.2, 4.0], (len(rotations), 1)) if translations is None else translations
    candidates = Candidates(quat[None], places[None], np.asarray(confidences)[None])
    return select_poses(candidates, Symmetries.of([group]), np.array([1.4]), method)[0]


@pytest.mark.parametrize("method", AVERAGES)
def test_without_any_confidence_all_count_the_same(method: Selection) -> None:
    chosen = select([np.eye(3), np.eye(3)], np.zeros(2), method, ALONE, np.array([[0.0, 0.0, 4.0], [0.01, 0.0, 4.0]]))
    assert np.allclose(chosen[:3, 3], [0.005, 0.0, 4.0])


@pytest.mark.parametrize("method", AVERAGES)
def test_symmetric_equivalents_are_one_pose(method: Selection) -> None:
    rotation = rotation_x(0.3)
    T = select([rotation, rotation @ rotation_z(np.pi)] * 4, np.array([0.9, 0.8] * 4), method)
    assert rotation_angle(T[:3, :3], rotation) < 1e-9


@pytest.mark.parametrize("method", AVERAGES)
def test_a_symmetry_about_an_axis_beside_the_origin_moves_it(method: Selection) -> None:
    """A half turn about the line x = 0.5 m takes the origin to x = 1 m."""
    half_turn = make_transform(rotation_z(np.pi), np.array([1.0, 0.0, 0.0]))
    T = make_transform(rotation_x(0.3) @ rotation_z(0.2), np.array([0.5, -0.2, 4.0]))
    other = T @ half_turn
    group = SymmetryGroup(np.stack([np.eye(4), half_turn]))
    places = np.stack([T[:3, 3], other[:3, 3]])
    found = select([T[:3, :3], other[:3, :3]], np.array([0.9, 0.8]), method, group, places)
    np.testing.assert_allclose(found, T, atol=1e-9)


def test_argmax_takes_the_most_confident() -> None:
    T = select([rotation_z(a) for a in (0.0, 0.5, 1.0)], np.array([0.2, 0.9, 0.3]), "argmax")
    np.testing.assert_allclose(T[:3, :3], rotation_z(0.5), atol=1e-12)


def test_average_is_that_of_markley() -> None:
    rng = np.random.default_rng(0)
    quats = np.array([1.0, 0.3, -0.2, 0.1]) + rng.normal(0, 0.1, (20, 4))
    weights = rng.uniform(0.1, 1, 20)
    unit = quats / np.linalg.norm(quats, axis=1, keepdims=True)
    principal = np.linalg.eigh(np.einsum("n,ni,nj->ij", weights, unit, unit))[1][:, -1]
    translations = rng.normal(size=(20, 3))
    T = select(list(matrix_from_quat_wxyz(quats)), weights, "weighted", ALONE, translations)
    np.testing.assert_allclose(T[:3, :3], matrix_from_quat_wxyz(principal), atol=1e-12)
    np.testing.assert_allclose(T[:3, 3], np.average(translations, axis=0, weights=weights), atol=1e-12)


def test_outliers_are_left_out_by_the_robust_methods() -> None:
    rotations = [np.eye(3)] * 6 + [rotation_x(1.0)] * 2
    places = np.array([[0.5, -0.2, 4.0]] * 6 + [[1.0, -0.2, 4.0]] * 2)
    confidences = np.array([0.9] * 6 + [0.2] * 2)
    cases: list[tuple[Selection, bool]] = [("weighted", False), ("weighted-50", True), ("consensus", True)]
    for method, exact in cases:
        T = select(rotations, confidences, method, C2, places)
        assert (rotation_angle(T[:3, :3], np.eye(3)) < 1e-9) == exact
        assert (abs(T[0, 3] - 0.5) < 1e-9) == exact


@pytest.mark.parametrize("method", ["argmax", *AVERAGES])
def test_a_batch_gives_what_its_objects_give_alone(method: Selection) -> None:
    rng = np.random.default_rng(1)
    groups = [C2, ALONE, SymmetryGroup.cuboid()]
    quat = rng.normal(size=(3, 1, 4)) + rng.normal(0, 0.05, (3, 30, 4))
    candidates = Candidates(quat, rng.normal(0, 0.02, (3, 30, 3)), rng.uniform(0.1, 1, (3, 30)))
    diameters = np.array([1.4, 0.5, 0.7])
    together = select_poses(candidates, Symmetries.of(groups), diameters, method)
    for i, group in enumerate(groups):
        one = Candidates(quat[i : i + 1], candidates.translation[i : i + 1], candidates.confidence[i : i + 1])
        alone = select_poses(one, Symmetries.of([group]), diameters[i : i + 1], method)
        np.testing.assert_allclose(together[i], alone[0], atol=1e-9)
