"""How far a real rack is from its drawing: EN 15620:2008, tables 2 and 3, adjustable pallet racking of class 400.

The standard gives limits for an erected, unloaded rack. A draw is normal with a third of the limit as its deviation and
cut off at the limit, so that a rack is never out of tolerance and seldom near it. Axes as in a frame: x along the
aisle, y into the rack, z up (the standard calls them X, Z and Y).
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.pose import Transform, make_transform, rotation_x, rotation_y, rotation_z


@dataclass(frozen=True)
class RackTolerances:
    """Largest deviations of class 400; lengths in mm, the rest as named."""

    bay_width_mm: float = 3.0
    """A: clear width between two uprights (mm), >= 0."""
    frontage_mm: float = 10.0
    """B0: a rack's front against its line on the floor (mm), >= 0."""
    plumb: float = 1.0 / 350.0
    """Cx, Cz: a frame's top against its foot, as a fraction of its height, >= 0."""
    aisle_mm: float = 15.0
    """E: width of an aisle near the floor (mm), >= 0."""
    beam_mm: float = 3.0
    """Gy: a beam's level; the larger of this (mm) and ``beam_fraction`` of its length counts, >= 0."""
    beam_fraction: float = 1.0 / 500.0
    """Gy: the same as a fraction of the beam's length, >= 0."""
    twist_deg_per_m: float = 1.0
    """Tw: a beam's twist at half its length (deg a metre of it), >= 0."""
    deflection: float = 1.0 / 200.0
    """Sag of a fully loaded beam at half its length, as a fraction of the length (FEM 10.2.02, EN 15512), >= 0."""

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if value < 0.0:
                raise ValueError(f"{name} must be >= 0, found {value}")


def bay_widths(nominal: float, count: int, limits: RackTolerances, rng: np.random.Generator) -> Float[np.ndarray, " n"]:
    """Return the clear widths (m) of ``count`` neighbouring bays of ``nominal`` width (m)."""
    return nominal + _within(limits.bay_width_mm / 1000, rng, count)


def aisle_width(nominal: float, limits: RackTolerances, rng: np.random.Generator) -> float:
    """Return the width (m) of an aisle that was sampled as ``nominal`` (m)."""
    return nominal + float(_within(limits.aisle_mm / 1000, rng))


def frame_pose(height: float, limits: RackTolerances, rng: np.random.Generator) -> Transform:
    """Return ``T_nominal_frame`` of a frame of ``height`` (m): shifted on the floor and out of plumb about its foot.

    Both poses have their origin at the frame's centre. The middle of the foot stays on the floor; base plates dip or
    rise by 1.6 mm at the limit, which on site is the work of shims.
    """
    lean_x, lean_y = (float(lean) for lean in np.arctan(_within(limits.plumb, rng, 2)))
    shift = np.array([0.0, _within(limits.frontage_mm / 1000, rng), 0.0])
    to_foot = np.array([0.0, 0.0, height / 2])
    rotation = rotation_y(lean_x) @ rotation_x(-lean_y)
    return make_transform(translation=shift - to_foot) @ make_transform(rotation) @ make_transform(translation=to_foot)


def beam_pose(length: float, limits: RackTolerances, rng: np.random.Generator) -> Transform:
    """Return ``T_nominal_beam`` of a beam of ``length`` (m): its ends not quite level, its section a little twisted."""
    slope = float(_within(max(limits.beam_mm / 1000, limits.beam_fraction * length), rng)) / length
    twist = float(np.deg2rad(_within(limits.twist_deg_per_m, rng) * length / 2))
    return make_transform(rotation_y(-float(np.arctan(slope))) @ rotation_x(twist))


def beam_sag(length: float, load_fraction: float, limits: RackTolerances) -> float:
    """Return how far (m) a beam of ``length`` (m) sags at its middle under ``load_fraction`` (0-1) of its safe load."""
    return limits.deflection * length * load_fraction


def rack_yaw(length: float, limits: RackTolerances, rng: np.random.Generator) -> Float[np.ndarray, "3 3"]:
    """Return the turn about the vertical of a whole rack of ``length`` (m) whose ends miss their line differently."""
    first, last = _within(limits.frontage_mm / 1000, rng, 2)
    return rotation_z(float(np.arctan((last - first) / length)))


def _within(limit: float, rng: np.random.Generator, count: int | None = None) -> Float[np.ndarray, "..."]:
    """Draw from the normal distribution of deviation ``limit`` / 3, cut off at +-``limit``."""
    return np.clip(rng.normal(0.0, limit / 3.0, count), -limit, limit)
