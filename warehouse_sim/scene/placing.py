"""What all places of unit loads have in common: the room that a load takes, and care where it is tight."""

import numpy as np

from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, make_transform
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.scene.unit_load import UnitLoad

_UNDERSIDE = 0.02
"""The envelope of a load begins here (m), so that the support itself is free."""


def envelope_of(load: UnitLoad) -> OrientedBox:
    """Return the box around all pieces of ``load`` in its frame.

    It goes by the collision boxes: the bounding box of a drum grows when the drum is turned, the drum does not.
    """
    boxes = [
        OrientedBox(T_load_piece @ box.T_parent_box, box.size)
        for model, T_load_piece in load.pieces
        for box in model.collision or (OrientedBox(np.eye(4), model.size),)
    ]
    lows, highs = BoxStack.of(boxes).extents()
    low, high = np.maximum(lows.min(axis=0), [-np.inf, -np.inf, _UNDERSIDE]), highs.max(axis=0)
    return OrientedBox(make_transform(translation=(low + high) / 2), high - low)


def placed(T_world_load: Transform, box: OrientedBox) -> OrientedBox:
    """Return a box of a load in the world."""
    return OrientedBox(T_world_load @ box.T_parent_box, box.size)


def care_after(tries: int, most: int) -> float:
    """Return by how much jitter is scaled after ``tries`` of ``most`` in vain: in full at first, to none at the end."""
    return min(1.0, 2.0 * (1.0 - tries / most))
