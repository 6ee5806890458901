"""What stands around the racks: floor slab, wall and high-bay luminaires; origin at the centre, z up."""

import numpy as np

from warehouse_sim.catalog.parts import box_part, collision_boxes
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.schema import ObjectModel, Part

FLOOR_SIZE = (48.0, 48.0, 0.2)
"""Edges of the slab (m)."""
WALL_SIZE = (48.0, 0.2, 9.0)
"""Edges of a wall (m), x along it."""
LUMINAIRE_SIZE = (1.2, 0.32, 0.09)
"""Edges of a linear high-bay luminaire (m)."""


def floor_slab(name: str = "floor_slab") -> ObjectModel:
    """Build the concrete slab; its top is 0.1 m above its centre."""
    return _static(name, "floor", 201, FLOOR_SIZE, (box_part(FLOOR_SIZE, (0.0, 0.0, 0.0), "concrete"),))


def wall(name: str = "wall") -> ObjectModel:
    """Build a wall of painted panels above a concrete plinth."""
    length, thickness, height = WALL_SIZE
    plinth = 0.4
    parts = (
        box_part((length, thickness, plinth), (0.0, 0.0, (plinth - height) / 2), "concrete"),
        box_part((length, thickness, height - plinth), (0.0, 0.0, plinth / 2), "wall_paint"),
    )
    return _static(name, "wall", 202, WALL_SIZE, parts)


def highbay_luminaire(name: str = "highbay_luminaire") -> ObjectModel:
    """Build a linear LED luminaire that shines down."""
    length, width, height = LUMINAIRE_SIZE
    glow = 0.01
    parts = (
        box_part((length, width, height - glow), (0.0, 0.0, glow / 2), "galvanised"),
        box_part((length - 0.04, width - 0.04, glow), (0.0, 0.0, (glow - height) / 2), "led_panel"),
    )
    return _static(name, "luminaire", 203, LUMINAIRE_SIZE, parts)


def _static(
    name: str, class_name: str, obj_id: int, size: tuple[float, float, float], parts: tuple[Part, ...]
) -> ObjectModel:
    return ObjectModel(
        name=name,
        class_name=class_name,
        obj_id=obj_id,
        size=np.array(size),
        parts=parts,
        collision=collision_boxes(parts),
        symmetry=SymmetryGroup.turns("z", 2),
    )
