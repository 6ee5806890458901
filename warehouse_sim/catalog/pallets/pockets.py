"""Where forks enter a pallet: two windows on a face, and the prisms behind them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.schema import ObjectModel, Part, Pocket

_INWARDS = {"-x": (1.0, 0.0), "+x": (-1.0, 0.0), "-y": (0.0, 1.0), "+y": (0.0, -1.0)}


@dataclass(frozen=True)
class Window:
    """One of the two equal openings of a face, left and right of its middle."""

    width: float
    """Clear width (m)."""
    offset: float
    """From the middle of the face to the middle of the window (m)."""
    bottom: float
    """Height of its sill above the ground (m); 0 where a fork may slide in along the ground."""
    top: float
    """Height of its lintel above the ground (m)."""


def window_between(outer: float, middle: float, length: float, bottom: float, top: float) -> Window:
    """Return the window beside the middle one of three uprights that stand on a face.

    Args:
        outer: Width of the two uprights at the ends of the face (m).
        middle: Width of the upright in its middle (m).
        length: Length of the face (m).
        bottom: Height of the sill above the ground (m).
        top: Height of the lintel above the ground (m).
    """
    width = (length - 2 * outer - middle) / 2.0
    return Window(width, (middle + width) / 2.0, bottom, top)


def pockets_behind(windows: dict[str, Window], size: Float[np.ndarray, " 3"]) -> tuple[Pocket, ...]:
    """Return two pockets for each face, which run through to the opposite face.

    Args:
        windows: Face ("-x", "+x", "-y", "+y") -> its windows; a face that is left out cannot be entered.
        size: Outer edge lengths of the pallet (m), its origin at the centre.
    """
    pockets = []
    for face, window in windows.items():
        x, y = inwards = np.array(_INWARDS[face])
        rotation = np.array([[x, -y, 0.0], [y, x, 0.0], [0.0, 0.0, 1.0]])
        depth = float(size["xy".index(face[1])])
        height = (window.bottom + window.top) / 2.0 - float(size[2]) / 2.0
        for side in (-1.0, 1.0):
            centre = np.append(-inwards * depth / 2.0, height) + side * window.offset * rotation[:, 1]
            prism = np.array([depth, window.width, window.top - window.bottom])
            pockets.append(Pocket(face, make_transform(rotation, centre), prism))
    return tuple(pockets)


def pallet_model(
    name: str,
    obj_id: int,
    mass: float,
    size: Float[np.ndarray, " 3"],
    parts: Sequence[Part],
    collision: Sequence[OrientedBox],
    windows: dict[str, Window],
    make: str = "",
) -> ObjectModel:
    """Return the pallet of these parts, with pockets behind its ``windows``; ``make`` is the mark that it bears."""
    return ObjectModel(
        name=name,
        class_name="pallet",
        obj_id=obj_id,
        size=size,
        parts=tuple(parts),
        collision=tuple(collision),
        mass=mass,
        symmetry=SymmetryGroup.turns("z", 2),
        pockets=pockets_behind(windows, size),
        make=make,
    )
