import numpy as np
import torch
from scipy.spatial.transform import Rotation

from warehouse_sim.estimators.pose.densefusion.networks.rotations import fit_pose, matrix_from_quat_wxyz


def made_fit(count: int = 40, batch: int = 5) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor, torch.Tensor]:
    torch.manual_seed(0)
    rotation = matrix_from_quat_wxyz(torch.randn(batch, 4))
    translation, object_points = torch.randn(batch, 3), torch.randn(batch, count, 3)
    return rotation, translation, object_points, object_points @ rotation.mT + translation[:, None]


def test_agrees_with_scipy_on_noisy_points_of_one_scale() -> None:
    _, _, object_points, points = made_fit()
    # Errors far below the smallest that counts: no reweighting, plain least squares.
    points = points + 1e-3 * torch.randn_like(points)
    quat, _, _ = fit_pose(object_points, points, torch.full((5, 40), 2.0))
    for i in range(5):
        a, b = points[i].double().numpy(), object_points[i].double().numpy()
        expected = Rotation.align_vectors(a - a.mean(axis=0), b - b.mean(axis=0))[0].as_matrix()
        np.testing.assert_allclose(matrix_from_quat_wxyz(quat[i]).numpy(), expected, atol=1e-4)


def test_never_mirrors() -> None:
    _, _, object_points, points = made_fit()
    mirrored = points * torch.tensor([1.0, 1.0, -1.0])
    for cloud in (points, mirrored, object_points * torch.tensor([1.0, 1.0, 0.0])):
        quat, _, _ = fit_pose(object_points, cloud, torch.zeros(5, 40))
        torch.testing.assert_close(torch.linalg.det(matrix_from_quat_wxyz(quat)), torch.ones(5))


def test_few_gross_errors_and_points_that_uncertainty_themselves_do_not_count() -> None:
    rotation, _, object_points, points = made_fit()
    scale = torch.full((5, 40), -4.0)
    wild = points.clone()
    wild[:, :6] += 2.0 * torch.randn(5, 6, 3)
    quat, _, weights = fit_pose(object_points, wild, scale)
    assert float((matrix_from_quat_wxyz(quat) - rotation).abs().max()) < 0.02
    assert float(weights[:, :6].sum(dim=1).max()) < 0.05
    wild[:, 6:20] += torch.randn(5, 14, 3)
    with_model = scale.clone()
    with_model[:, :20] = 1.0
    quat, _, _ = fit_pose(object_points, wild, with_model)
    assert float((matrix_from_quat_wxyz(quat) - rotation).abs().max()) < 1e-2


def test_gradient_is_that_of_the_whole_fit() -> None:
    # Scales so large that nothing is reweighted: the weights are constants, as the gradient takes them to be.
    _, _, object_points, points = made_fit(count=6, batch=1)
    points = points + 0.1 * torch.randn_like(points)
    scale = torch.linspace(2.0, 4.0, 6)[None] + 6.0
    probe_q, probe_t = torch.randn(1, 3, 3), torch.randn(1, 3)

    def value(moved: torch.Tensor, log_scale: torch.Tensor) -> torch.Tensor:
        quat, translation, _ = fit_pose(moved, points, log_scale)
        return (matrix_from_quat_wxyz(quat) * probe_q).sum() + (translation * probe_t).sum()

    moved, log_scale = object_points.clone().requires_grad_(), scale.clone().requires_grad_()
    value(moved, log_scale).backward()
    step = 1e-2
    for i in range(6):
        for axis in range(3):
            change = torch.zeros_like(object_points)
            change[0, i, axis] = step
            numeric = (value(object_points + change, scale) - value(object_points - change, scale)) / (2 * step)
            assert abs(float(numeric) - float(moved.grad[0, i, axis])) < 2e-2 * float(moved.grad.abs().max()) + 1e-3
    assert bool(log_scale.grad.any())


def test_gradient_is_finite_where_the_pose_is_not_determined() -> None:
    line = torch.linspace(-1.0, 1.0, 8)[None, :, None] * torch.tensor([1.0, 0.0, 0.0])
    for cloud in (line, torch.zeros_like(line)):
        moved, scale = cloud.clone().requires_grad_(), torch.zeros(1, 8, requires_grad=True)
        quat, translation, _ = fit_pose(moved, cloud, scale)
        (quat.sum() + translation.sum()).backward()
        assert bool(moved.grad.isfinite().all())
        assert bool(scale.grad.isfinite().all())
