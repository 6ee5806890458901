"""Rotations as tensors, and the one that fits two clouds best."""

import torch
from jaxtyping import Float
from torch import Tensor


def matrix_from_quat_wxyz(quat_wxyz: Float[Tensor, "*batch 4"]) -> Float[Tensor, "*batch 3 3"]:
    """Return rotation matrices of quaternions, which are normalised first."""
    w, x, y, z = torch.nn.functional.normalize(quat_wxyz, dim=-1).unbind(-1)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return torch.stack([torch.stack(row, dim=-1) for row in rows], dim=-2)


def multiply_quat_wxyz(a: Float[Tensor, "*batch 4"], b: Float[Tensor, "*batch 4"]) -> Float[Tensor, "*batch 4"]:
    """Return the quaternion of the rotation b followed by the rotation a."""
    w, v = a[..., :1], a[..., 1:]
    other_w, other_v = b[..., :1], b[..., 1:]
    scalar = w * other_w - (v * other_v).sum(dim=-1, keepdim=True)
    return torch.cat([scalar, w * other_v + other_w * v + torch.linalg.cross(v, other_v)], dim=-1)


def matrix_from_vector(vector: Float[Tensor, "*batch 3"]) -> Float[Tensor, "*batch 3 3"]:
    """Return rotations about the axes of ``vector`` by its length (rad)."""
    half = vector / 2.0
    angle = half.norm(dim=-1, keepdim=True)
    return matrix_from_quat_wxyz(torch.cat([angle.cos(), half * torch.sinc(angle / torch.pi)], dim=-1))


def compose(
    R_a: Float[Tensor, "*batch 3 3"], t_a: Float[Tensor, "*batch 3"], R_b: Float[Tensor, "*batch 3 3"],
    t_b: Float[Tensor, "*batch 3"],
) -> tuple[Float[Tensor, "*batch 3 3"], Float[Tensor, "*batch 3"]]:  # fmt: skip
    """Return rotation and translation of ``T_a @ T_b``."""
    return R_a @ R_b, (R_a @ t_b[..., None])[..., 0] + t_a


_ROUNDS = 3
# An error below this fraction of its scale counts as this fraction, or one point would outweigh all others.
_SMALLEST = 0.1
# Keeps rotations defined that the points hardly determine, say about the axis of a row of points.
_RIDGE = 1e-3
# A power of 2^12 tells eigenvalues apart that differ by a few thousandths of the matrix's norm.
_SQUARINGS = 12


def fit_pose(
    object_points: Float[Tensor, "b n 3"], points: Float[Tensor, "b n 3"], log_scale: Float[Tensor, "b n"]
) -> tuple[Float[Tensor, "b 4"], Float[Tensor, "b 3"], Float[Tensor, "b n"]]:
    """Return quaternion (wxyz, unit), translation and final weights of ``points ~ R object_points + t``.

    Gradients reach the object points and the scales; the errors that reweight count as constants.

    Args:
        object_points: Predicted coordinates in the object's frame.
        points: The measured points that they belong to.
        log_scale: ln b of each point's Laplace distribution.
    """
    with torch.autocast(points.device.type, enabled=False):
        object_points, points, log_scale = object_points.float(), points.float(), log_scale.float()
        # Only ratios of weights matter: the smallest scale is 1 here, and nothing overflows.
        precision = torch.exp(log_scale.amin(dim=1, keepdim=True) - log_scale)
        weights = precision.square()
        with torch.no_grad():
            for _ in range(_ROUNDS):
                quat, translation = _weighted_fit(object_points, points, weights)
                residual = points - object_points @ matrix_from_quat_wxyz(quat).mT - translation[:, None]
                floor = _SMALLEST * torch.exp(log_scale)
                damping = torch.rsqrt(residual.square().sum(dim=-1) + floor.square())
                damping = damping / damping.amax(dim=1, keepdim=True)
                weights = precision * damping
        weights = precision * damping
        return *_weighted_fit(object_points, points, weights), weights / weights.sum(dim=1, keepdim=True)


def _weighted_fit(
    object_points: Float[Tensor, "b n 3"], points: Float[Tensor, "b n 3"], weights: Float[Tensor, "b n"]
) -> tuple[Float[Tensor, "b 4"], Float[Tensor, "b 3"]]:
    fraction = (weights / weights.sum(dim=1, keepdim=True))[..., None]
    object_centre, centre = (fraction * object_points).sum(dim=1), (fraction * points).sum(dim=1)
    # Rows: measured axes, columns: object axes.
    covariance = ((points - centre[:, None]) * fraction).mT @ (object_points - object_centre[:, None])
    quat = _rotation_of(covariance)
    return quat, centre - (matrix_from_quat_wxyz(quat) @ object_centre[..., None])[..., 0]


def _rotation_of(covariance: Float[Tensor, "b 3 3"]) -> Float[Tensor, "b 4"]:
    """Return the rotation that maximises trace(R^T covariance), with its gradient.

    One Newton step from the solution moves nothing, but has the exact gradient (implicit function theorem), which
    stays finite where that of an eigenvector or of an SVD does not. All of it is plain products, which an exporter to
    other runtimes knows.
    """
    with torch.no_grad():
        size = covariance.square().sum(dim=(1, 2), keepdim=True).sqrt() + 1e-12
        quat = _principal_vector(_horn_matrix(covariance / size))
        R = matrix_from_quat_wxyz(quat)
        stretch = R.mT @ covariance / size
        trace = stretch.diagonal(dim1=-2, dim2=-1).sum(dim=-1)[:, None, None]
        curvature = (trace + _RIDGE) * torch.eye(3, device=covariance.device) - (stretch + stretch.mT) / 2.0
        inverse = _inverse(curvature)
    step = (inverse @ _axis(R.mT @ covariance / size)[..., None])[..., 0]
    turn = torch.cat([torch.ones_like(step[:, :1]), step / 2.0], dim=-1)
    return torch.nn.functional.normalize(multiply_quat_wxyz(quat, turn), dim=-1)


def _principal_vector(matrix: Float[Tensor, "b 4 4"]) -> Float[Tensor, "b 4"]:
    """Return the unit eigenvector of the largest eigenvalue of symmetric matrices, by squaring them again and again."""
    norm = matrix.square().sum(dim=(1, 2), keepdim=True).sqrt() + 1e-12
    # Shifted by its norm no eigenvalue is negative, and the largest is largest in size.
    power = matrix / norm + torch.eye(4, device=matrix.device)
    for _ in range(_SQUARINGS):
        power = power @ power
        power = power / power.diagonal(dim1=-2, dim2=-1).sum(dim=-1)[:, None, None]
    # What is left is v v^T; its longest column is the one with the largest diagonal element.
    longest = power.diagonal(dim1=-2, dim2=-1).argmax(dim=-1)[:, None, None].expand(-1, 4, 1)
    return torch.nn.functional.normalize(torch.gather(power, 2, longest)[..., 0], dim=-1)


def _inverse(matrix: Float[Tensor, "b 3 3"]) -> Float[Tensor, "b 3 3"]:
    x, y, z = matrix.unbind(dim=-1)
    rows = [torch.linalg.cross(y, z), torch.linalg.cross(z, x), torch.linalg.cross(x, y)]
    determinant = (x * rows[0]).sum(dim=-1)[:, None, None]
    return torch.stack(rows, dim=-2) / determinant.clamp(min=1e-12)


def _axis(matrix: Float[Tensor, "b 3 3"]) -> Float[Tensor, "b 3"]:
    difference = matrix - matrix.mT
    return torch.stack([difference[:, 2, 1], difference[:, 0, 2], difference[:, 1, 0]], dim=-1)


def _horn_matrix(covariance: Float[Tensor, "b 3 3"]) -> Float[Tensor, "b 4 4"]:
    trace = covariance.diagonal(dim1=-2, dim2=-1).sum(dim=-1)
    axis = _axis(covariance)
    lower = covariance + covariance.mT - trace[:, None, None] * torch.eye(3, device=covariance.device)
    top = torch.cat([trace[:, None], axis], dim=-1)[:, None]
    return torch.cat([top, torch.cat([axis[..., None], lower], dim=-1)], dim=-2)
