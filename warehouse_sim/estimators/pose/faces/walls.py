"""What the walls of pockets do to borders that are found by depth, and how it is taken back.

Seen from aside or from above, the first centimetres of a wall behind the face are no farther from the plane than noise
is: the wall counts as face, and the opening looks narrower by their depth times the slope of the rays. Which wall that
is, and how much, geometry says.
"""

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from warehouse_sim.estimators.pose.faces.plane_view import PlaneView
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
from warehouse_sim.geometry.pose import invert

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
