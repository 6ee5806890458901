"""The bricks of the catalog: painted boxes and other solids, and boxes that physics collides with."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.mesh import TriangleMesh, merge, unit_box
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.geometry.solids import Outline, prism
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.schema import LuminousFace, ObjectModel, Part

Triple = Sequence[float] | Float[np.ndarray, " 3"]
"""Three numbers: a place or edge lengths (m)."""


Size = tuple[float, float, float]
"""Edge lengths along x, y and z (m)."""


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


def mesh_part(
    mesh: TriangleMesh,
    material: str,
    centre: Triple = (0.0, 0.0, 0.0),
    rotation: Float[np.ndarray, "3 3"] | None = None,
) -> Part:
    """Return ``mesh`` as large as it is, turned and put at ``centre`` (m)."""
    return solid_part(mesh, (1.0, 1.0, 1.0), centre, material, rotation)


def slab_part(outline: Outline, low: float, high: float, material: str) -> Part:
    """Return an upright prism over ``outline`` (x, y; m) from the height ``low`` to ``high`` (m)."""
    return solid_part(prism(outline), (1.0, 1.0, high - low), (0.0, 0.0, (low + high) / 2), material)


def lofted(rings: Float[np.ndarray, "k n 3"]) -> TriangleMesh:
    """Return the closed surface through rings that run counter-clockwise about the way from the first to the last."""
    count, sides = rings.shape[:2]
    index = np.arange(count * sides).reshape(count, sides)
    right = np.roll(index, -1, axis=1)
    foot, top = np.full(sides, count * sides), np.full(sides, count * sides + 1)
    faces = [
        np.stack([index[:-1], right[:-1], right[1:]], axis=-1).reshape(-1, 3),
        np.stack([index[:-1], right[1:], index[1:]], axis=-1).reshape(-1, 3),
        np.column_stack([right[0], index[0], foot]),
        np.column_stack([index[-1], right[-1], top]),
    ]
    vertices = np.concatenate([rings.reshape(-1, 3), rings[[0, -1]].mean(axis=1)])
    return TriangleMesh(vertices, np.concatenate(faces).astype(np.int32))


def fused(parts: Sequence[Part]) -> tuple[Part, ...]:
    """Return one part a material, in the order in which materials first occur.

    A renderer draws each part by itself: of a thing of many small pieces it is cheaper to draw the whole.
    """
    names = dict.fromkeys(part.material for part in parts)
    return tuple(
        Part(merge([part.placed() for part in parts if part.material == name]), np.ones(3), np.eye(4), name)
        for name in names
    )


def model_of(
    name: str,
    class_name: str,
    obj_id: int,
    size: Triple,
    parts: Sequence[Part],
    collision: Sequence[OrientedBox] | None = None,
    *,
    mass: float = 0.0,
    turns: int = 1,
    symmetry: SymmetryGroup | None = None,
    luminous_face: LuminousFace | None = None,
    bears: float | None = None,
) -> ObjectModel:
    """Return the model of an object that is centred on the origin.

    Args:
        name: Catalog name.
        class_name: Detection class.
        obj_id: Number of the geometry.
        size: Outer edges (m).
        parts: What is drawn.
        collision: Boxes for physics; the box around all of it by default.
        mass: Kilograms, 0 for what never moves.
        turns: Number of equal turns about z that leave the look unchanged.
        symmetry: What leaves the look unchanged where that is no turn about z.
        luminous_face: Where light comes out of it.
        bears: What may stand on it (kg); None leaves it to its class.
    """
    if symmetry is None:
        symmetry = SymmetryGroup.turns("z", turns) if turns > 1 else SymmetryGroup.trivial()
    return ObjectModel(
        name=name,
        class_name=class_name,
        obj_id=obj_id,
        size=np.array(size, dtype=float),
        parts=tuple(parts),
        collision=(solid_box(size),) if collision is None else tuple(collision),
        mass=mass,
        symmetry=symmetry,
        luminous_face=luminous_face,
        bears=bears,
    )
