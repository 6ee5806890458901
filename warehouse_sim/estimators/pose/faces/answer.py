"""The answer that a forklift needs, out of a plane and a face on it."""

import numpy as np
from jaxtyping import Float

from warehouse_sim.estimators.pose.faces.shape import (
    BOARD,
    FOOT,
    HEIGHT,
    MIDDLE,
    POCKET_HEIGHT,
    POCKET_WIDTH,
    POST,
    WIDTH,
)
from warehouse_sim.estimators.pose.faces.solid import SolidPlane
from warehouse_sim.estimators.pose.faces.template import FrontFit
from warehouse_sim.geometry.pose import Transform, make_transform
from warehouse_sim.schema import PalletFace


def describe(T_camera_plane: Transform, fit: FrontFit, plane: SolidPlane, roll: float, bias: float) -> PalletFace:
    """Return dock frame, pockets and sizes with their covariances.

    Args:
        T_camera_plane: The plane.
        fit: The face on it.
        plane: How sure the plane is.
        roll: How sure the turn in the plane is (rad).
        bias: What all readings are off together (m, standard deviation).
    """
    q, to = fit.shape, _sums()
    middle = to["middle"] @ q
    aside = float(q[POST] + q[POCKET_WIDTH]) / 2.0
    own = to["pocket"] @ fit.covariance @ to["pocket"].T
    offset = np.diag([(to["aside"] @ fit.covariance @ to["aside"]), 1e-8])
    size = fit.covariance[np.ix_([WIDTH, HEIGHT], [WIDTH, HEIGHT])]
    return PalletFace(
        T_camera_plane @ make_transform(np.eye(3), np.array([0.0, *middle])),
        _covariance(middle, to["middle"] @ fit.covariance @ to["middle"].T, plane, roll, bias),
        np.array([[-aside, 0.0], [aside, 0.0]]),
        np.stack([offset, offset]),
        np.tile(q[[POCKET_WIDTH, POCKET_HEIGHT]], (2, 1)),
        np.stack([own, own]),
        q[[WIDTH, HEIGHT]],
        size,
    )


def _sums() -> dict[str, Float[np.ndarray, "..."]]:
    """Return how the answer's numbers are sums of a face's."""
    one = np.eye(8)
    return {
        "middle": np.stack([one[MIDDLE], one[FOOT] + one[BOARD] + one[POCKET_HEIGHT] / 2.0]),
        "pocket": np.stack([one[POCKET_WIDTH], one[POCKET_HEIGHT]]),
        "aside": (one[POST] + one[POCKET_WIDTH]) / 2.0,
    }


def _covariance(
    middle: Float[np.ndarray, " 2"],
    in_plane: Float[np.ndarray, "2 2"],
    plane: SolidPlane,
    roll: float,
    bias: float,
) -> Float[np.ndarray, "6 6"]:
    """Return the covariance of the dock frame's small motion in itself."""
    # The plane's turns and its shift along x at its own origin, carried to the dock frame's origin.
    carry = np.zeros((6, 3))
    carry[2, 0], carry[1, 1], carry[3] = 1.0, 1.0, [-middle[0], middle[1], 1.0]
    found = carry @ plane.covariance @ carry.T
    found[0, 0] += roll**2
    found[4:, 4:] += in_plane
    found[3, 3] += bias**2
    return np.asarray(found)
