"""The Chamfer distance against a slow count, k-d trees and Open3D, and as a loss."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from scipy.spatial import cKDTree

from tests.dataset.toy import PALLET
from tests.estimators.pose.densefusion.made_crops import DIAMETER, MESH, pallet_shape, pose
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.estimators.pose.densefusion.losses import chamfer_distance, loss_distance
from warehouse_sim.estimators.pose.densefusion.networks.interface import GroundTruth
from warehouse_sim.estimators.pose.densefusion.objects import measure_shape, shape_tensors
from warehouse_sim.estimators.pose.densefusion.settings import LossConfig
from warehouse_sim.geometry.mesh import sample_surface
from warehouse_sim.geometry.pose import make_transform, rotation_x, rotation_z, transform_points

SCALE = DIAMETER / 2
SURFACE = sample_surface(MESH, 300, np.random.default_rng(2))[0]
ONE_CLASS = torch.zeros(1, dtype=torch.long)


def shapes_with(surface: np.ndarray):
    return shape_tensors([replace(pallet_shape(), surface=tuple(surface.ravel().tolist()))])


def normalised(T: np.ndarray) -> tuple[torch.Tensor, torch.Tensor]:
    return torch.tensor(T[None, :3, :3]).float(), torch.tensor(T[None, :3, 3] / SCALE).float()


def distance(T: np.ndarray, T_gt: np.ndarray, squared: bool, surface: np.ndarray = SURFACE) -> float:
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
        a, b = transform_points(T, SURFACE), transform_points(T_gt, SURFACE)
        trees = np.mean(cKDTree(b).query(a)[0] ** power) + np.mean(cKDTree(a).query(b)[0] ** power)
        clouds = [open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points)) for points in (a, b)]
        there, back = (
            clouds[0].compute_point_cloud_distance(clouds[1]),
            clouds[1].compute_point_cloud_distance(clouds[0]),
        )
        theirs = np.mean(np.asarray(there) ** power) + np.mean(np.asarray(back) ** power)
        assert distance(T, T_gt, squared) == pytest.approx(trees, rel=1e-4)
        assert theirs == pytest.approx(trees, rel=1e-9)


@pytest.mark.parametrize("squared", [False, True])
def test_many_poses_of_several_classes_are_measured_as_each_alone(squared: bool) -> None:
    torch.manual_seed(0)
    both = [replace(pallet_shape(), obj_id=k, surface=tuple((SURFACE[k::7] * k).ravel())) for k in (1, 2)]
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
        loss = loss_distance(rotation, translation + shift, gt, shapes_with(SURFACE), config).sum()
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
        assert distance(T @ element, T, False, surface) < 1e-3
    assert distance(T @ make_transform(rotation_z(np.pi / 2)), T, False, surface) > 0.05


def test_metres_scale_with_the_object_and_squares_with_its_square() -> None:
    (T, T_gt), *_ = pairs()
    rotation, translation = normalised(T)
    gt, shapes = GroundTruth(*normalised(T_gt), ONE_CLASS), shapes_with(SURFACE)
    for name, power in (("surface", 1), ("chamfer", 1), ("chamfer-squared", 2)):
        ours, metres = (
            float(loss_distance(rotation[None], translation[None], gt, shapes, LossConfig(distance=name, unit=unit)))
            for unit in ("half-diameters", "metres")
        )
        assert metres == pytest.approx(ours * SCALE**power, rel=1e-5)
