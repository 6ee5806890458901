"""Cartons that are being picked from: some of those that nothing stands on have their flaps open."""

from dataclasses import replace

import numpy as np

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.loads.open_cartons import OPEN_CARTONS
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.schema import ObjectInstance, ObjectModel

_PICKED_BELOW = 2.2
"""Height up to which people pick (m)."""
_LIFT = 0.003
"""Free height over the flaps (m)."""
_BONDS = ("wrap", "corner_post")
_WAYS = {sku: [name for name, (one, _) in OPEN_CARTONS.items() if one == sku] for sku, _ in OPEN_CARTONS.values()}


def open_flaps(draft: SceneDraft, fraction: float, rng: np.random.Generator) -> None:
    """Open a fraction (0-1) of the cartons up to picking height, where there is room above; ids and places stay.

    Loads with film or posts around them, and what is fixed behind the aisle, stay closed.
    """
    if fraction == 0.0:
        return
    held = {item.group for item in draft.instances if draft.models[item.model].class_name in _BONDS}
    solids = draft.solids()
    opened: list[OrientedBox] = []
    for place, item in enumerate(draft.instances):
        behind = item.group > 0 and not item.dynamic
        low = item.T_world_object[2, 3] - draft.models[item.model].size[2] / 2
        if item.model not in _WAYS or behind or (item.group > 0 and item.group in held) or low > _PICKED_BELOW:
            continue
        if rng.random() >= fraction:
            continue
        model, closed = catalog_object(_WAYS[item.model][int(rng.integers(2))]), draft.models[item.model]
        room = _room_of_flaps(item, closed, model)
        corners = room.corners()
        near = solids.near(corners.min(axis=0), corners.max(axis=0), 0.01) & (solids.owner != item.instance_id)
        if solids.boxes.subset(near).clear_of(room, 0.0) and BoxStack.of(opened).clear_of(room, 0.0):
            draft.models[model.name] = model
            rise = make_transform(translation=np.array([0.0, 0.0, (model.size[2] - closed.size[2]) / 2]))
            draft.instances[place] = replace(item, model=model.name, T_world_object=item.T_world_object @ rise)
            opened.append(room)
    used = {item.model for item in draft.instances}
    for name in [name for name in draft.models if name not in used]:
        del draft.models[name]


def _room_of_flaps(item: ObjectInstance, closed: ObjectModel, model: ObjectModel) -> OrientedBox:
    """Return the box over a closed carton that the flaps of the open one take."""
    length, width, height = model.size - [0.0, 0.0, closed.size[2]]
    T_object_room = make_transform(translation=np.array([0.0, 0.0, (closed.size[2] + height) / 2 + _LIFT]))
    return OrientedBox(item.T_world_object @ T_object_room, np.array([length, width, height]))
