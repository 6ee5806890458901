"""Distances of poses against closed forms, k-d trees and Open3D, and the losses that are made of them."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from scipy.spatial import cKDTree

from tests.dataset.toy import PALLET
from tests.estimators.pose.densefusion.made_crops import DIAMETER, MESH, pallet_shape, pose
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.estimators.pose.densefusion.losses import (
    chamfer_distance,
    confidence_loss,
    coordinate_loss,
    equivalent_poses,
    loss_distance,
    pose_distance,
)
from warehouse_sim.estimators.pose.densefusion.networks.interface import GroundTruth
from warehouse_sim.estimators.pose.densefusion.networks.rotations import matrix_from_quat_wxyz
from warehouse_sim.estimators.pose.densefusion.objects import measure_shape, shape_tensors
from warehouse_sim.estimators.pose.densefusion.settings import LossConfig, SymmetryLoss
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


FEW = sample_surface(MESH, 300, np.random.default_rng(2))[0]


def shapes_with(surface: np.ndarray):
    return shape_tensors([replace(pallet_shape(), surface=tuple(surface.ravel().tolist()))])


def chamfer(T: np.ndarray, T_gt: np.ndarray, squared: bool, surface: np.ndarray = FEW) -> float:
    """In metres, or square metres."""
    rotation, translation = normalised(T)
    gt = GroundTruth(*normalised(T_gt), ONE_CLASS)
    found = chamfer_distance(rotation[None], translation[None], gt, shapes_with(surface), squared)
    return float(found[0, 0]) * (SCALE**2 if squared else SCALE)


def pairs(count: int = 4) -> list[tuple[np.ndarray, np.ndarray]]:
    rng = np.random.default_rng(0)
    found = []
    for _ in range(count):
        T = pose(rng)
        found.append((T @ make_transform(rotation_z(rng.normal(0, 0.4)) @ rotation_x(0.1), rng.normal(0, 0.1, 3)), T))
    return found


@pytest.mark.parametrize("squared", [False, True])
def test_it_is_what_trees_and_open3d_measure(squared: bool) -> None:
    open3d = pytest.importorskip("open3d")
    power = 2 if squared else 1
    for T, T_gt in pairs():
        a, b = transform_points(T, FEW), transform_points(T_gt, FEW)
        trees = np.mean(cKDTree(b).query(a)[0] ** power) + np.mean(cKDTree(a).query(b)[0] ** power)
        clouds = [open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points)) for points in (a, b)]
        there, back = (
            clouds[0].compute_point_cloud_distance(clouds[1]),
            clouds[1].compute_point_cloud_distance(clouds[0]),
        )
        theirs = np.mean(np.asarray(there) ** power) + np.mean(np.asarray(back) ** power)
        assert chamfer(T, T_gt, squared) == pytest.approx(trees, rel=1e-4)
        assert theirs == pytest.approx(trees, rel=1e-9)


@pytest.mark.parametrize("squared", [False, True])
def test_many_poses_of_several_classes_are_measured_as_each_alone(squared: bool) -> None:
    torch.manual_seed(0)
    both = [replace(pallet_shape(), obj_id=k, surface=tuple((FEW[k::7] * k).ravel())) for k in (1, 2)]
    shapes, found = shape_tensors(both), pairs(6)
    chosen = torch.tensor([0, 1])
    R, t = (torch.cat(values) for values in zip(*(normalised(T) for T, _ in found), strict=True))
    gt = GroundTruth(*(torch.cat(v) for v in zip(*(normalised(T) for _, T in found[:2]), strict=True)), chosen)
    at_once = chamfer_distance(R.view(2, 3, 3, 3), t.view(2, 3, 3), gt, shapes, squared)
    for row in range(2):
        one = GroundTruth(gt.rotation[row : row + 1], gt.translation[row : row + 1], chosen[row : row + 1])
        for column in range(3):
            k = 3 * row + column
            alone = chamfer_distance(R[k : k + 1, None], t[k : k + 1, None], one, shapes, squared)
            torch.testing.assert_close(at_once[row, column], alone[0, 0])


@pytest.mark.parametrize("distance_name", ["chamfer", "chamfer-squared"])
def test_its_gradient_is_finite_at_the_true_pose_and_leads_back_to_it(distance_name: str) -> None:
    _, T = pairs()[0]
    gt, config = GroundTruth(*normalised(T), ONE_CLASS), LossConfig(distance=distance_name)
    for step in (0.0, 1e-3):
        rotation, translation = (value[None].clone().requires_grad_() for value in normalised(T))
        shift = torch.tensor([step, 0.0, 0.0])
        loss = loss_distance(rotation, translation + shift, gt, shapes_with(FEW), config).sum()
        loss.backward()
        for value in (rotation, translation):
            assert bool(value.grad.isfinite().all())
        if step == 0.0:
            assert float(translation.grad.abs().max()) < 1e-3
        else:
            assert float(translation.grad[0, 0, 0]) > 0.0


def test_look_alikes_cost_nothing_with_the_points_that_a_run_keeps(toy_root: Path) -> None:
    shape = measure_shape(DatasetReader(toy_root).objects[1], np.random.default_rng(0), surface_points=128)
    surface = np.reshape(shape.surface, (-1, 3))
    assert len(surface) == 128
    T = pose(np.random.default_rng(1))
    for element in PALLET.symmetry.transforms:
        assert chamfer(T @ element, T, False, surface) < 1e-3
    assert chamfer(T @ make_transform(rotation_z(np.pi / 2)), T, False, surface) > 0.05


def test_metres_scale_with_the_object_and_squares_with_its_square() -> None:
    (T, T_gt), *_ = pairs()
    rotation, translation = normalised(T)
    gt, shapes = GroundTruth(*normalised(T_gt), ONE_CLASS), shapes_with(FEW)
    for name, power in (("surface", 1), ("chamfer", 1), ("chamfer-squared", 2)):
        ours, metres = (
            float(loss_distance(rotation[None], translation[None], gt, shapes, LossConfig(distance=name, unit=unit)))
            for unit in ("half-diameters", "metres")
        )
        assert metres == pytest.approx(ours * SCALE**power, rel=1e-5)
