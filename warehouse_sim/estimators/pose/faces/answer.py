"""The answer that a forklift needs, out of a plane and a face on it, less what pockets' walls did to its borders."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from warehouse_sim.estimators.pose.faces.planes import PlaneView, SolidPlane
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
from warehouse_sim.estimators.pose.faces.template import FrontFit
from warehouse_sim.geometry.pose import Transform, invert, make_transform
from warehouse_sim.schema import PalletFace

_BORDER_PX = 0.3
"""Error of a border in the image (px): that of rounding to whole pixels."""
_UNSURE = 0.3
"""Fraction of the correction that stays unsure: walls are rounded, and rims are read between two surfaces."""


def without_walls(fit: FrontFit, view: PlaneView, sigma: float, known_sizes: bool) -> FrontFit:
    """Return a face as it is without the walls that were taken for it, and with the error of its borders.

    Args:
        fit: The face as it was found.
        view: The plane.
        sigma: Error of readings across the plane (m).
        known_sizes: Whether a catalog gave the sizes, which then stay.
    """
    q = fit.shape
    camera = invert(view.T_camera_plane)[:3, 3]
    height = q[FOOT] + q[BOARD] + q[POCKET_HEIGHT] / 2.0
    aside, up = (np.array([q[MIDDLE], height]) - camera[1:]) / max(-camera[0], 0.1)
    deep = sigma * np.sqrt(2.0 * np.log(max(0.4 / sigma, 1.5)))
    narrower, lower = deep * abs(aside), deep * abs(up)
    change = np.zeros(8)
    change[MIDDLE] = deep * aside / 2.0
    if known_sizes:
        change[FOOT] = deep * up / 2.0
    else:
        change[[WIDTH, POST, POCKET_WIDTH]] = -narrower, -narrower, narrower
        change[POCKET_HEIGHT] = lower
        if up < 0.0:
            # Seen from above: the top of the deck, and that of the boards under the pockets or the floor.
            change[BOARD] = -min(lower, q[BOARD])
            change[HEIGHT], change[POCKET_HEIGHT] = -lower, -change[BOARD]
    covariance = fit.covariance + _border_errors(view, narrower, lower)
    return replace(fit, shape=q + change, covariance=covariance)


def _border_errors(view: PlaneView, narrower: float, lower: float) -> Float[np.ndarray, "8 8"]:
    pixel = _BORDER_PX * view.cell / np.sqrt(max(view.pixels_a_cell, 1e-6))
    side, upright = np.hypot(pixel, _UNSURE * narrower), np.hypot(pixel, _UNSURE * lower)
    deviation = np.zeros(8)
    # Two borders make a width, and the middle is the mean of four.
    deviation[[WIDTH, POST, POCKET_WIDTH]] = np.sqrt(2.0) * side
    deviation[[HEIGHT, POCKET_HEIGHT]] = np.sqrt(2.0) * upright
    deviation[MIDDLE], deviation[FOOT] = np.hypot(pixel / 2.0, _UNSURE * narrower / 2.0), upright / np.sqrt(2.0)
    return np.diag(deviation**2)


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
