"""Models of the fixed parts of a building, and the solid that profiled sheets are made of."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from warehouse_sim.catalog.parts import collision_boxes
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.schema import LuminousFace, ObjectModel, Part

Size = tuple[float, float, float]


def building_model(
    name: str,
    class_name: str,
    obj_id: int,
    size: Size,
    parts: Sequence[Part],
    collision: Sequence[OrientedBox] | None = None,
    turns: int = 1,
    mass: float = 0.0,
    luminous_face: LuminousFace | None = None,
) -> ObjectModel:
    """Return the model of something that stands or hangs in the hall.

    Args:
        name: Catalog name.
        class_name: Detection class.
        obj_id: Number of the geometry.
        size: Outer edges (m).
        parts: What is sampled.
        collision: Boxes for physics; those of ``parts``, which then are boxes, by default.
        turns: Number of equal turns about z that leave the look unchanged.
        mass: Kilograms, 0 for what never moves.
        luminous_face: Where light comes out of it.
    """
    return ObjectModel(
        name=name,
        class_name=class_name,
        obj_id=obj_id,
        size=np.array(size),
        parts=tuple(parts),
        collision=collision_boxes(parts) if collision is None else tuple(collision),
        mass=mass,
        symmetry=SymmetryGroup.turns("z", turns) if turns > 1 else SymmetryGroup.trivial(),
        luminous_face=luminous_face,
    )


def profiled_solid(
    x: Float[np.ndarray, " n"], low: Float[np.ndarray, " n"], high: Float[np.ndarray, " n"], length: float
) -> TriangleMesh:
    """Return the watertight solid between two lines y = low(x) < high(x), extruded along z about 0 (m)."""
    count = len(x)
    y = np.concatenate([low, high, low, high])
    z = np.repeat([-length / 2, length / 2], 2 * count)
    a, b = np.arange(count - 1), np.arange(1, count)
    n, ends = count, np.array([0, count - 1])
    quads = [
        np.column_stack([a, b, b + 2 * n, a + 2 * n]),  # low side
        np.column_stack([b + n, a + n, a + 3 * n, b + 3 * n]),  # high side
        np.column_stack([b, a, a + n, b + n]),  # foot
        np.column_stack([a, b, b + n, a + n]) + 2 * n,  # top
        np.array([[n, 0, 2 * n, 3 * n], [0, n, 3 * n, 2 * n] + ends[1]]),  # both ends
    ]
    corners = np.concatenate(quads)
    faces = np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])
    return TriangleMesh(np.column_stack([np.tile(x, 4), y, z]), faces.astype(np.int32))
