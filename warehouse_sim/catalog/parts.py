"""The bricks of the catalog: painted boxes and other solids, and boxes that physics collides with."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.mesh import TriangleMesh, merge, unit_box
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.schema import Part

Triple = Sequence[float] | Float[np.ndarray, " 3"]
"""Three numbers: a place or edge lengths (m)."""


def box_part(size: Triple, centre: Triple, material: str, rotation: Float[np.ndarray, "3 3"] | None = None) -> Part:
    """Return a painted box.

    Args:
        size: Edge lengths (m) along the box's own axes.
        centre: Position in the object frame (m).
        material: Name of a material.
        rotation: Orientation in the object frame; the object's own axes by default.
    """
    T_object_part = make_transform(rotation, np.asarray(centre, dtype=float))
    return Part(unit_box(), np.asarray(size, dtype=float), T_object_part, material)


def in_role(parts: Sequence[Part], role: str) -> list[Part]:
    """Return ``parts`` as pieces of one role in their object."""
    return [replace(part, role=role) for part in parts]


def collision_boxes(parts: Sequence[Part]) -> tuple[OrientedBox, ...]:
    """Return the boxes that stand for parts made of unit boxes, one for one."""
    return tuple(OrientedBox(part.T_object_part, part.scale) for part in parts)


def solid_box(size: Triple, centre: Triple = (0.0, 0.0, 0.0)) -> OrientedBox:
    """Return a collision box of edge lengths ``size`` (m) at ``centre`` (m), parallel to the object's axes."""
    return OrientedBox(make_transform(translation=np.asarray(centre, dtype=float)), np.asarray(size, dtype=float))


def solid_part(
    mesh: TriangleMesh,
    size: Triple,
    centre: Triple,
    material: str,
    rotation: Float[np.ndarray, "3 3"] | None = None,
) -> Part:
    """Return ``mesh`` stretched by ``size`` along its own axes, turned and put at ``centre`` (m)."""
    T_object_part = make_transform(rotation, np.asarray(centre, dtype=float))
    return Part(mesh, np.asarray(size, dtype=float), T_object_part, material)


def fused(parts: Sequence[Part]) -> tuple[Part, ...]:
    """Return one part a material, in the order in which materials first occur.

    A renderer draws each part by itself: of a thing of many small pieces it is cheaper to draw the whole.
    """
    names = dict.fromkeys(part.material for part in parts)
    return tuple(
        Part(merge([part.placed() for part in parts if part.material == name]), np.ones(3), np.eye(4), name)
        for name in names
    )
