"""Bars and wires that boxes of mesh and cages are welded of."""

import numpy as np

from warehouse_sim.catalog.parts import box_part
from warehouse_sim.schema import Part

Axis = int


def wire_panel(
    normal: Axis,
    at: float,
    across: tuple[float, float],
    up: tuple[float, float],
    pitch: tuple[float, float],
    wire: float,
    material: str,
) -> list[Part]:
    """Return a panel of upright and level wires, square in section, in a plane across x (0) or y (1).

    Args:
        normal: Axis that the panel is perpendicular to, 0 or 1.
        at: Place along it (m).
        across: First and last place along the other level axis (m).
        up: Lower and upper edge (m).
        pitch: Greatest distance of upright and of level wires (m).
        wire: Edge of a wire (m).
        material: Its material.
    """
    (left, right), (low, high) = across, up
    pieces = []
    for place in stations(left, right, pitch[0]):
        pieces.append(bar(normal, at, (place, (low + high) / 2), (wire, high - low), wire, material))
    for level in stations(low, high, pitch[1]):
        pieces.append(bar(normal, at, ((left + right) / 2, level), (right - left, wire), wire, material))
    return pieces


def bar(
    normal: Axis,
    at: float,
    centre: tuple[float, float],
    size: tuple[float, float],
    thick: float,
    material: str,
) -> Part:
    """Return a box in a plane across x or y: ``centre`` and ``size`` are along the other level axis and z (m)."""
    if normal == 0:
        return box_part((thick, size[0], size[1]), (at, *centre), material)
    return box_part((size[0], thick, size[1]), (centre[0], at, centre[1]), material)


def stations(first: float, last: float, pitch: float) -> list[float]:
    """Return evenly spaced places from ``first`` to ``last`` (m), at most ``pitch`` (m) apart."""
    return [float(place) for place in np.linspace(first, last, max(2, int(np.ceil((last - first) / pitch)) + 1))]


def ring(length: float, width: float, low: float, high: float, thick: float, material: str) -> list[Part]:
    """Return four bars around a rectangle, flush with its edges (m)."""
    middle, rise = (low + high) / 2, high - low
    long = [box_part((length, thick, rise), (0.0, s * (width - thick) / 2, middle), material) for s in (-1, 1)]
    inner = width - 2 * thick
    return [
        *long,
        *(box_part((thick, inner, rise), (s * (length - thick) / 2, 0.0, middle), material) for s in (-1, 1)),
    ]
