"""Film torn off a load on a rack: it hangs over the front of the beam, before what stands below."""

from dataclasses import replace

import numpy as np

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.traffic.obstacles import WRAPS
from warehouse_sim.geometry.pose import make_transform, rotation_z
from warehouse_sim.scene.draft import Area, SceneDraft

_LEAST_HEIGHT = 0.9
"""Loads lower than this (m) are not on a rack's beam, or too low for film to hang from."""
_AIR = 0.01
"""Distance of the film from the load's front (m)."""
_SIDE = 0.25
"""How far to both sides of the load's middle it hangs (m)."""


def hang_film(draft: SceneDraft, count: int, area: Area, rng: np.random.Generator) -> None:
    """Hang film from up to ``count`` loads that stand high enough beside the aisle ``area``; it belongs to its load."""
    pallets = [
        item
        for item in draft.instances
        if draft.models[item.model].class_name == "pallet" and item.T_world_object[2, 3] > _LEAST_HEIGHT
    ]
    for index in rng.permutation(len(pallets))[:count]:
        pallet, model = pallets[index], draft.models[pallets[index].model]
        fitting = [name for name in WRAPS if catalog_object(name).size[2] < pallet.T_world_object[2, 3] - 0.1]
        film = catalog_object(str(rng.choice(fitting)))
        # Towards the aisle: -y for what stands on the front side, +y for the side opposite.
        side = -1.0 if pallet.T_world_object[1, 3] > area.y_max else 1.0
        reach = np.abs(pallet.T_world_object[1, :2]) @ model.size[:2] / 2
        x = pallet.T_world_object[0, 3] + rng.uniform(-_SIDE, _SIDE)
        y = pallet.T_world_object[1, 3] + side * (reach + _AIR + film.size[0] / 2)
        z = pallet.T_world_object[2, 3] + model.size[2] / 2 - film.size[2] / 2
        T_world_film = make_transform(rotation_z(side * np.pi / 2), np.array([x, y, z]))
        instance = draft.add(film, T_world_film, pallet.group)
        draft.instances[-1] = replace(instance, dynamic=False)
