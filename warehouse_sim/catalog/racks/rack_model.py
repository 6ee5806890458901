"""How the pieces of racks are made into objects: class rack, small parts fused, the mesh's box as size."""

from collections.abc import Sequence

import numpy as np

from warehouse_sim.catalog.parts import fused
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.schema import ObjectModel, Part


def rack_model(
    name: str,
    obj_id: int,
    size: tuple[float, float, float],
    parts: Sequence[Part],
    collision: Sequence[OrientedBox],
    class_name: str = "rack",
    mass: float = 0.0,
    turns: int = 1,
) -> ObjectModel:
    """Return the object; ``turns`` about the vertical leave it as it is."""
    symmetry = SymmetryGroup.turns("z", turns) if turns > 1 else SymmetryGroup.trivial()
    return ObjectModel(
        name=name,
        class_name=class_name,
        obj_id=obj_id,
        size=np.array(size),
        parts=fused(parts),
        collision=tuple(collision),
        mass=mass,
        symmetry=symmetry,
    )
