"""Rigid transforms: ``T_a_b`` maps points of frame b into frame a, so neighbours cancel."""

from functools import lru_cache

import numpy as np
from jaxtyping import Float

Transform = Float[np.ndarray, "4 4"]
Transforms = Float[np.ndarray, "*batch 4 4"]
_IDENTITY = np.eye(4)


def make_transform(
    rotation: Float[np.ndarray, "*batch 3 3"] | None = None, translation: Float[np.ndarray, "*batch 3"] | None = None
) -> Transforms:
    """Assemble 4x4 transforms from rotations and translations (m); what is omitted is the identity."""
    batch: tuple[int, ...] = ()
    if rotation is not None:
        batch = rotation.shape[:-2]
    elif translation is not None:
        batch = np.shape(translation)[:-1]
    # One pose is what is requested most, tens of thousands of times a scene.
    T = np.broadcast_to(_IDENTITY, (*batch, 4, 4)).copy() if batch else _IDENTITY.copy()
    if rotation is not None:
        T[..., :3, :3] = rotation
    if translation is not None:
        T[..., :3, 3] = translation
    return T


def invert(T: Transforms) -> Transforms:
    """Return ``T_b_a`` for ``T_a_b``, using that the rotation part is orthonormal."""
    R_t = np.swapaxes(T[..., :3, :3], -1, -2)
    return make_transform(R_t, -np.einsum("...ij,...j->...i", R_t, T[..., :3, 3]))


def transform_points(T: Transforms, points: Float[np.ndarray, "*batch n 3"]) -> Float[np.ndarray, "*batch n 3"]:
    """Map ``points`` (m) of frame b into frame a by ``T_a_b``."""
    return points @ np.swapaxes(T[..., :3, :3], -1, -2) + T[..., None, :3, 3]


def rotation_x(angle: float) -> Float[np.ndarray, "3 3"]:
    """Return the rotation by ``angle`` (rad) about the x axis."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def rotation_y(angle: float) -> Float[np.ndarray, "3 3"]:
    """Return the rotation by ``angle`` (rad) about the y axis."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def rotation_z(angle: float) -> Float[np.ndarray, "3 3"]:
    """Return the rotation by ``angle`` (rad) about the z axis."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def matrix_from_quat_wxyz(quat_wxyz: Float[np.ndarray, "*batch 4"]) -> Float[np.ndarray, "*batch 3 3"]:
    """Return rotation matrices of quaternions, which are normalised first."""
    q = quat_wxyz / np.linalg.norm(quat_wxyz, axis=-1, keepdims=True)
    w, x, y, z = np.moveaxis(q, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def quat_wxyz_from_matrix(rotation: Float[np.ndarray, "3 3"]) -> Float[np.ndarray, " 4"]:
    """Return the unit quaternion with w >= 0 of a rotation matrix.

    The quaternion is the principal eigenvector of Bar-Itzhack's symmetric matrix (J. Guidance 23(6), 2000),
    which is stable for every angle.
    """
    return _quat_of(np.ascontiguousarray(rotation, dtype=float).tobytes()).copy()


@lru_cache(1024)
def _quat_of(rotation: bytes) -> Float[np.ndarray, " 4"]:
    """Return the quaternion of nine numbers; boxes of a scene have few orientations."""
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = np.frombuffer(rotation).reshape(3, 3)
    n = np.array(
        [
            [xx + yy + zz, zy - yz, xz - zx, yx - xy],
            [zy - yz, xx - yy - zz, xy + yx, xz + zx],
            [xz - zx, xy + yx, yy - xx - zz, yz + zy],
            [yx - xy, xz + zx, yz + zy, zz - xx - yy],
        ]
    )
    quat = np.linalg.eigh(n)[1][:, -1]
    return quat if quat[0] >= 0 else -quat


def rotation_angle(
    R_a: Float[np.ndarray, "*batch 3 3"], R_b: Float[np.ndarray, "*batch 3 3"]
) -> Float[np.ndarray, "*batch"]:
    """Return the angle (rad) of the rotation between ``R_a`` and ``R_b``, accurate near 0.

    Uses the chord ``||R_a - R_b||_F = 2 sqrt(2) sin(angle / 2)``, where arccos of the trace would lose half the digits.
    """
    chord = np.linalg.norm(R_a - R_b, axis=(-2, -1))
    return 2.0 * np.arcsin(np.clip(chord / (2.0 * np.sqrt(2.0)), 0.0, 1.0))


def level_camera(position: Float[np.ndarray, " 3"], yaw: float, pitch: float = 0.0, roll: float = 0.0) -> Transform:
    """Return ``T_world_camera`` of an OpenCV camera (x right, y down, z forward).

    Args:
        position: Optical centre in the world (m).
        yaw: Heading of the optical axis about world z (rad); 0 looks along +x.
        pitch: Tilt of the optical axis (rad); positive looks up.
        roll: Turn about the optical axis (rad).
    """
    forward_left_up_from_camera = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    R = rotation_z(yaw) @ rotation_y(-pitch) @ forward_left_up_from_camera @ rotation_z(roll)
    return make_transform(R, np.asarray(position, dtype=float))


def look_at(position: Float[np.ndarray, " 3"], target: Float[np.ndarray, " 3"]) -> Transform:
    """Return ``T_world_camera`` of an OpenCV camera that looks at a point, its image upright.

    Args:
        position: Optical centre in the world (m).
        target: What the optical axis goes through (m), another point; straight up and down, +x is up in the image.

    Raises:
        ValueError: Both are the same point.
    """
    ahead = np.asarray(target, dtype=float) - np.asarray(position, dtype=float)
    flat = float(np.hypot(ahead[0], ahead[1]))
    if flat == 0.0 and ahead[2] == 0.0:
        raise ValueError("a camera cannot look at the place where it is")
    return level_camera(position, float(np.arctan2(ahead[1], ahead[0])), float(np.arctan2(ahead[2], flat)))
