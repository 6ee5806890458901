import math
from dataclasses import replace

import numpy as np
import pytest
import torch
from scipy.spatial import cKDTree

from tests.dataset.toy import PALLET
from tests.estimators.pose.densefusion.made_crops import DIAMETER, MESH, pallet_shape, pose
from warehouse_sim.estimators.pose.densefusion.losses import (
    confidence_loss,
    coordinate_loss,
    equivalent_poses,
    pose_distance,
)
from warehouse_sim.estimators.pose.densefusion.networks.interface import GroundTruth
from warehouse_sim.estimators.pose.densefusion.networks.rotations import matrix_from_quat_wxyz
from warehouse_sim.estimators.pose.densefusion.objects import shape_tensors
from warehouse_sim.estimators.pose.densefusion.settings import SymmetryLoss
from warehouse_sim.geometry.mesh import sample_surface
from warehouse_sim.geometry.pose import make_transform, rotation_x, rotation_z, transform_points

SURFACE = sample_surface(MESH, 2000, np.random.default_rng(2))[0]
SHAPES = shape_tensors([replace(pallet_shape(), surface=tuple(SURFACE.ravel().tolist()))])
SCALE = DIAMETER / 2
LEAST = 1e-4 * SCALE  # what keeps the square root differentiable
ONE_CLASS = torch.zeros(1, dtype=torch.long)


def normalised(T: np.ndarray) -> tuple[torch.Tensor, torch.Tensor]:
    return torch.tensor(T[None, :3, :3]).float(), torch.tensor(T[None, :3, 3] / SCALE).float()


def distance(T_predicted: np.ndarray, T_gt: np.ndarray, symmetry: SymmetryLoss = "group") -> float:
    """Distance of two poses in metres."""
    rotation, translation = normalised(T_predicted)
    gt = GroundTruth(*normalised(T_gt), ONE_CLASS)
    return float(pose_distance(rotation[None], translation[None], gt, SHAPES, symmetry)[0, 0]) * SCALE


@pytest.mark.parametrize("element", range(len(PALLET.symmetry.transforms)))
def test_each_declared_look_alike_costs_nothing(element: int) -> None:
    T = make_transform(rotation_x(0.4), np.array([0.2, 0.1, 0.4]))
    assert distance(T @ PALLET.symmetry.transforms[element], T) == pytest.approx(LEAST, rel=0.05)


def test_distance_is_the_rms_distance_of_the_surface() -> None:
    rng = np.random.default_rng(0)
    points, _ = sample_surface(MESH, 100_000, np.random.default_rng(1))
    for _ in range(5):
        T_gt = pose(rng)
        T = T_gt @ make_transform(rotation_z(rng.normal(0, 0.2)) @ rotation_x(0.1), rng.normal(0, 0.05, 3))
        moved = transform_points(T, points) - transform_points(T_gt, points)
        assert distance(T, T_gt) == pytest.approx(np.sqrt((moved**2).sum(axis=1).mean()), rel=1e-4)


def test_without_symmetry_look_alikes_are_told_apart() -> None:
    T = make_transform(rotation_x(0.4), np.array([0.2, 0.1, 0.4]))
    turned = T @ make_transform(rotation_z(np.pi))
    assert distance(T, T, "none") == pytest.approx(LEAST, rel=0.05)
    moved = transform_points(turned, SURFACE) - transform_points(T, SURFACE)
    assert distance(turned, T, "none") == pytest.approx(np.sqrt((moved**2).sum(axis=1).mean()), rel=0.03)


def test_nearest_point_distance_is_add_s() -> None:
    rng = np.random.default_rng(3)
    for _ in range(3):
        T_gt = pose(rng)
        T = T_gt @ make_transform(rotation_z(rng.normal(0, 0.3)), rng.normal(0, 0.05, 3))
        far, _ = cKDTree(transform_points(T_gt, SURFACE)).query(transform_points(T, SURFACE))
        assert distance(T, T_gt, "nearest") == pytest.approx(far.mean(), rel=2e-3)


def test_nearest_points_are_for_symmetric_classes_only() -> None:
    plain = replace(pallet_shape(), obj_id=2, symmetries=pallet_shape().symmetries[:1], surface=tuple(SURFACE.ravel()))
    shapes = shape_tensors([replace(plain, symmetries=pallet_shape().symmetries), plain])
    assert shapes.is_symmetric().tolist() == [True, False]
    rotation, shift = torch.eye(3).expand(2, 1, 3, 3), torch.full((2, 1, 3), 0.05)
    gt = GroundTruth(torch.eye(3).expand(2, 3, 3), torch.zeros(2, 3), torch.tensor([0, 1]))
    near, rms = (pose_distance(rotation, shift, gt, shapes, kind)[:, 0] for kind in ("nearest", "none"))
    assert float(near[0]) < 0.9 * float(rms[0])
    assert torch.equal(near[1], rms[1])


def test_the_nearest_equivalent_is_chosen_for_each_prediction() -> None:
    # Twelve classes of group sizes 1 and 2 are mixed in a batch; the long way round goes over all equivalents.
    torch.manual_seed(0)
    alone = replace(pallet_shape(), obj_id=2, symmetries=pallet_shape().symmetries[:1])
    shapes = shape_tensors([pallet_shape(), alone])
    gt = GroundTruth(matrix_from_quat_wxyz(torch.randn(12, 4)), torch.randn(12, 3), torch.arange(12) % 2)
    rotation, translation = matrix_from_quat_wxyz(torch.randn(12, 7, 4)), torch.randn(12, 7, 3)
    R, t = equivalent_poses(gt, shapes)
    each = [
        pose_distance(rotation, translation, GroundTruth(R[:, g], t[:, g], gt.class_index), shapes, "none")
        for g in range(R.shape[1])
    ]
    found = pose_distance(rotation, translation, gt, shapes)
    torch.testing.assert_close(found, torch.stack(each).amin(dim=0))


def test_mixed_precision_does_not_reach_the_distance() -> None:
    rng = np.random.default_rng(4)
    T_gt, T = pose(rng), pose(rng)
    for symmetry in ("group", "none", "nearest"):
        exact = distance(T, T_gt, symmetry)
        with torch.autocast("cpu", torch.bfloat16):
            assert distance(T, T_gt, symmetry) == exact


@pytest.mark.parametrize("element", range(len(PALLET.symmetry.transforms)))
def test_coordinates_of_any_look_alike_are_as_good(element: int) -> None:
    T = pose(np.random.default_rng(5))
    seen = transform_points(T, SURFACE[:50])
    coordinates = transform_points(np.linalg.inv(T @ PALLET.symmetry.transforms[element]), seen)
    points, predicted = (torch.tensor(array[None] / SCALE).float() for array in (seen, coordinates))
    log_scale = torch.full((1, 50), -3.0)
    gt = GroundTruth(*normalised(T), ONE_CLASS)
    # Errors are zero but for what keeps the square root differentiable: 3 ln b, and 1e-4 / b.
    expected = -9.0 + 1e-4 * math.exp(3.0)
    assert float(coordinate_loss(predicted, log_scale, points, gt, SHAPES)) == pytest.approx(expected, abs=2e-3)
    apart = float(coordinate_loss(predicted, log_scale, points, gt, SHAPES, "none"))
    is_identity = np.allclose(PALLET.symmetry.transforms[element], np.eye(4))
    assert (apart < -8.9) == is_identity


def test_loss_has_its_known_value() -> None:
    # c = 0.5: 0.2 * 0.5 + 0.08 * ln 2
    loss = confidence_loss(torch.full((2, 3), 0.2), torch.zeros(2, 3), 0.08)
    assert float(loss) == pytest.approx(0.1 + 0.08 * math.log(2), rel=1e-6)


def test_hopeless_confidence_stays_finite() -> None:
    logit = torch.tensor([[-500.0]], requires_grad=True)
    loss = confidence_loss(torch.tensor([[1.0]]), logit, 0.08)
    loss.backward()
    assert bool(torch.isfinite(loss))
    assert float(logit.grad) == pytest.approx(-0.08)
