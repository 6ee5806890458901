"""How far a real rack is from its drawing: EN 15620:2008, tables 2 and 3, adjustable pallet racking of class 400.

The standard gives limits for an erected, unloaded rack. A draw is normal with a third of the limit as its deviation and
cut off at the limit, so that a rack is never out of tolerance and seldom near it. Axes as in a frame: x along the
aisle, y into the rack, z up (the standard calls them X, Z and Y).
"""

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.pose import Transform, make_transform, rotation_x, rotation_y

FRONTAGE = 0.010
"""B0: a rack's front against its line on the floor (m)."""
PLUMB = 1.0 / 350.0
"""Cx, Cz: a frame's top against its foot, as a fraction of its height."""
BEAM_LEVEL, BEAM_FRACTION = 0.003, 1.0 / 500.0
"""Gy: a beam's level; the larger of a length (m) and a fraction of the beam's length counts."""
TWIST_DEG_PER_M = 1.0
"""Tw: a beam's twist at half its length (deg a metre of it)."""


def frame_pose(height: float, rng: np.random.Generator) -> Transform:
    """Return ``T_nominal_frame`` of a frame of ``height`` (m): shifted on the floor and out of plumb about its foot.

    Both poses have their origin at the frame's centre. The middle of the foot stays on the floor; base plates dip or
    rise by 1.6 mm at the limit, which on site is the work of shims.
    """
    lean_x, lean_y = (float(lean) for lean in np.arctan(_within(PLUMB, rng, 2)))
    shift = np.array([0.0, _within(FRONTAGE, rng), 0.0])
    to_foot = np.array([0.0, 0.0, height / 2])
    rotation = rotation_y(lean_x) @ rotation_x(-lean_y)
    return make_transform(translation=shift - to_foot) @ make_transform(rotation) @ make_transform(translation=to_foot)


def beam_pose(length: float, rng: np.random.Generator) -> Transform:
    """Return ``T_nominal_beam`` of a beam of ``length`` (m): its ends not quite level, its section a little twisted."""
    slope = float(_within(max(BEAM_LEVEL, BEAM_FRACTION * length), rng)) / length
    twist = float(np.deg2rad(_within(TWIST_DEG_PER_M, rng) * length / 2))
    return make_transform(rotation_y(-float(np.arctan(slope))) @ rotation_x(twist))


def _within(limit: float, rng: np.random.Generator, count: int | None = None) -> Float[np.ndarray, "..."]:
    """Draw from the normal distribution of deviation ``limit`` / 3, cut off at +-``limit``."""
    return np.clip(rng.normal(0.0, limit / 3.0, count), -limit, limit)
