"""Rotations as tensors."""

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
