"""The big door at ground level that trucks drive through.

Origin at the centre of the bounding box, z up, y out of the hall. Its leaf is one flat sheet of a material of its own,
so that the same geometry can be a shut door or an open one that shows the sky.
"""

import numpy as np

from warehouse_sim.catalog.building.building_model import building_model
from warehouse_sim.catalog.parts import box_part, collision_boxes, fused
from warehouse_sim.schema import LuminousFace, ObjectModel

GATE_SIZE = (4.2, 0.14, 4.4)
"""Outer width, depth and height of the drive-in door with its frame (m)."""
_LEAF_SIZE = (3.8, 4.2)  # width and height of its leaf, or of the sky that it shows when open (m)
_LEAF_MATERIAL = "gate_leaf"


def drive_in_door(name: str = "drive_in_door") -> ObjectModel:
    """Build the door: a leaf on the floor between two jambs and the box of its roller, before the wall's inner face."""
    width, depth, height = GATE_SIZE
    leaf_width, leaf_height = _LEAF_SIZE
    jamb, lintel, floor = (width - leaf_width) / 2, height - leaf_height, -height / 2
    frame = [
        box_part((jamb, depth, height), (side * (width - jamb) / 2, 0.0, 0.0), "galvanised") for side in (-1.0, 1.0)
    ]
    frame.append(box_part((leaf_width, depth, lintel), (0.0, 0.0, (height - lintel) / 2), "galvanised"))
    thick = 0.04
    leaf = box_part((leaf_width, thick, leaf_height), (0.0, depth / 2 - thick, floor + leaf_height / 2), _LEAF_MATERIAL)
    sky = LuminousFace(
        "daylight", _LEAF_MATERIAL, _LEAF_MATERIAL, np.array([0.0, 1.0, 0.0]), depth / 2, leaf_width * leaf_height
    )
    solid = collision_boxes([*frame, leaf])
    return building_model(name, "door", 154, GATE_SIZE, (*fused(frame), leaf), solid, luminous_face=sky)
