"""Which parts of an object cast a shadow of their own: print, labels and tape on a box have the box's."""

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.catalog.building.outdoors import OUTDOORS
from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.mesh import unit_box
from warehouse_sim.schema import Material, ObjectModel

_SKIN = 0.0015
"""What reaches no farther than this out of a box (m) has no shadow that a map would show."""
_PRINT = ("print_", "label_", "board_face", "tape", "strap", "brand_mark")
"""How materials are called that lie on something else, which has the shadow."""


def shadow_casters(model: ObjectModel, materials: dict[str, Material]) -> Bool[np.ndarray, " n"]:
    """Return the parts of ``model`` that cast shadows: neither film nor skin on a box that casts one itself.

    Nothing outdoors does: no light stands there, and a dome around all would take the resolution of every map.
    """
    if model.class_name == OUTDOORS:
        return np.zeros(len(model.parts), dtype=bool)
    casts = np.array([materials[part.material].opacity >= 1.0 for part in model.parts])
    printed = np.array([part.material.startswith(_PRINT) for part in model.parts])
    if not printed.all():
        casts &= ~printed
    boxes = [number for number, part in enumerate(model.parts) if casts[number] and part.mesh is unit_box()]
    corners = _corners(model)
    # From the largest box on, so that of two boxes in the same place one stays.
    for box in sorted(boxes, key=lambda number: -float(np.prod(model.parts[number].scale))):
        if casts[box]:
            part = model.parts[box]
            inside = (corners - part.T_object_part[:3, 3]) @ part.T_object_part[:3, :3]
            skin = (np.abs(inside) <= part.scale / 2 + _SKIN).all(axis=(1, 2))
            skin[box] = False
            casts &= ~skin
    return casts


def _corners(model: ObjectModel) -> Float[np.ndarray, "n 8 3"]:
    """Return the corners of each part's bounding box in the object frame (m)."""
    extent = {part.mesh: (part.mesh.vertices.min(axis=0), part.mesh.vertices.max(axis=0)) for part in model.parts}
    low, high = (np.stack([extent[part.mesh][side] * part.scale for part in model.parts]) for side in (0, 1))
    local = (low + high)[:, None] / 2 + box_corners(np.ones(3)) * (high - low)[:, None]
    T = np.stack([part.T_object_part for part in model.parts])
    return np.einsum("nij,nkj->nki", T[:, :3, :3], local) + T[:, None, :3, 3]
