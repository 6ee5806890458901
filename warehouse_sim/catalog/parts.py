"""The two bricks of the catalog: a painted box and a box that physics collides with."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.mesh import unit_box
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.schema import Part


def box_part(
    size: Sequence[float], centre: Sequence[float], material: str, rotation: Float[np.ndarray, "3 3"] | None = None
) -> Part:
    """Return a painted box.

    Args:
        size: Edge lengths (m) along the box's own axes.
        centre: Position in the object frame (m).
        material: Name of a material.
        rotation: Orientation in the object frame; the object's own axes by default.
    """
    T_object_part = make_transform(rotation, np.asarray(centre, dtype=float))
    return Part(unit_box(), np.asarray(size, dtype=float), T_object_part, material)


def collision_boxes(parts: Sequence[Part]) -> tuple[OrientedBox, ...]:
    """Return the boxes that stand for parts made of unit boxes, one for one."""
    return tuple(OrientedBox(part.T_object_part, part.scale) for part in parts)


def solid_box(size: Sequence[float], centre: Sequence[float] = (0.0, 0.0, 0.0)) -> OrientedBox:
    """Return a collision box of edge lengths ``size`` (m) at ``centre`` (m), parallel to the object's axes."""
    return OrientedBox(make_transform(translation=np.asarray(centre, dtype=float)), np.asarray(size, dtype=float))
