import numpy as np
import pytest

from warehouse_sim.estimators.select import select_pose
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
AVERAGES = ["wavg", "wavg50", "consensus"]


def poses(rotations: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    return np.stack(rotations), np.tile([0.5, -0.2, 4.0], (len(rotations), 1))


@pytest.mark.parametrize("method", ["argmax", *AVERAGES])
@pytest.mark.parametrize("angle", [0.0, 0.7, 3.0, np.pi])
def test_equal_poses_average_to_themselves(method: str, angle: float) -> None:
    rotation = rotation_x(0.4) @ rotation_z(angle)
    R, t = poses([rotation] * 7)
    T = select_pose(R, t, np.linspace(0.1, 0.9, 7), C2, 1.4, method)
    np.testing.assert_allclose(T, make_transform(rotation, t[0]), atol=1e-12)


@pytest.mark.parametrize("method", AVERAGES)
def test_symmetric_equivalents_are_one_pose(method: str) -> None:
    rotation = rotation_x(0.3)
    R, t = poses([rotation, rotation @ rotation_z(np.pi)] * 4)
    T = select_pose(R, t, np.array([0.9, 0.8] * 4), C2, 1.4, method)
    assert rotation_angle(T[:3, :3], rotation) < 1e-9


def test_argmax_takes_the_most_confident() -> None:
    R, t = poses([rotation_z(a) for a in (0.0, 0.5, 1.0)])
    T = select_pose(R, t, np.array([0.2, 0.9, 0.3]), C2, 1.4, "argmax")
    np.testing.assert_array_equal(T, make_transform(rotation_z(0.5), t[1]))


def test_average_is_that_of_markley() -> None:
    rng = np.random.default_rng(0)
    quats = np.array([1.0, 0.3, -0.2, 0.1]) + rng.normal(0, 0.1, (20, 4))
    weights = rng.uniform(0.1, 1, 20)
    unit = quats / np.linalg.norm(quats, axis=1, keepdims=True)
    principal = np.linalg.eigh(np.einsum("n,ni,nj->ij", weights, unit, unit))[1][:, -1]
    translations = rng.normal(size=(20, 3))
    T = select_pose(matrix_from_quat_wxyz(quats), translations, weights, SymmetryGroup.trivial(), 1.4, "wavg")
    np.testing.assert_allclose(T[:3, :3], matrix_from_quat_wxyz(principal), atol=1e-12)
    np.testing.assert_allclose(T[:3, 3], np.average(translations, axis=0, weights=weights), atol=1e-12)


def test_average_of_opposite_turns_is_between_them_by_weight() -> None:
    R, t = poses([rotation_z(0.2), rotation_z(-0.2)])
    T = select_pose(R, t, np.array([0.6, 0.6]), SymmetryGroup.trivial(), 1.4, "wavg")
    np.testing.assert_allclose(quat_wxyz_from_matrix(T[:3, :3]), [1, 0, 0, 0], atol=1e-12)


def test_outliers_are_left_out_by_the_robust_methods() -> None:
    R, t = poses([np.eye(3)] * 6 + [rotation_x(1.0)] * 2)
    t = t + np.array([[0.0, 0, 0]] * 6 + [[0.5, 0, 0]] * 2)
    confidences = np.array([0.9] * 6 + [0.2] * 2)
    for method, exact in (("wavg", False), ("wavg50", True), ("consensus", True)):
        T = select_pose(R, t, confidences, C2, 1.4, method)
        assert (rotation_angle(T[:3, :3], np.eye(3)) < 1e-9) == exact
        assert (abs(T[0, 3] - 0.5) < 1e-9) == exact
