"""A copper kettle drum with a hammered surface: an object with a material and a texture of its own."""

import numpy as np

from warehouse_sim.catalog.parts import solid_box, solid_part
from warehouse_sim.geometry.solids import unit_cylinder
from warehouse_sim.schema import Material, ObjectModel

COPPER = Material(
    "kettle_drum_copper",
    (0.62, 0.26, 0.14),
    roughness=0.4,
    texture="stranger_warehouse:textures/hammered",
    texture_size=0.2,
    remission=0.3,
)
_DIAMETER, _HEIGHT = 0.66, 0.60


def build(name: str) -> ObjectModel:
    """Return the drum: 0.66 m wide, 0.60 m high, 35 kg."""
    size = (_DIAMETER, _DIAMETER, _HEIGHT)
    body = solid_part(unit_cylinder(24), size, (0.0, 0.0, 0.0), COPPER.name)
    return ObjectModel(
        name, "kettle_drum", 2001, np.array(size), (body,), (solid_box(size),), mass=35.0, materials=(COPPER,)
    )
