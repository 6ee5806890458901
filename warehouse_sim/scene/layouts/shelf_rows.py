"""A row of shelving bays and what stands in them, fixed and at rest by construction: level on level shelves.

Frame of a row: x along it, its front at the plane y = 0, z up from the floor that it stands on.
"""

from functools import cache

import numpy as np

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.loads.cartons import SKUS
from warehouse_sim.catalog.loads.totes import TOTES
from warehouse_sim.catalog.racks.small_parts import BINS, SHELF_CLEARANCE, SHELF_SIZE, shelf_tops
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.layouts.site import Strip
from warehouse_sim.schema import ObjectModel

_CLEAR = SHELF_SIZE[0] - 0.06
"""Width of a shelf between the posts (m)."""
_DEPTH = SHELF_SIZE[1] - 0.02
"""Depth of a shelf before the cross of bars (m)."""
_PLAY = (0.004, 0.05)
"""Least and largest gap between two things on a shelf (m)."""
_BEHIND_EDGE = (0.01, 0.04)
"""How far behind a shelf's front edge things stand (m)."""
_QUARTER_TURN = rotation_z(np.pi / 2)


def add_shelf_row(
    draft: SceneDraft,
    T_world_row: Transform,
    bays: int,
    fill: float,
    rng: np.random.Generator,
    own_fraction: float = 0.0,
) -> list[Strip]:
    """Add ``bays`` bays centred on x = 0 and fill ``fill`` (0-1) of each shelf, one kind of thing a shelf.

    Return the shelves; the fraction ``own_fraction`` (0-1) of them is left to goods of the user's own.
    """
    strips = []
    for bay in range(bays):
        x = (bay - (bays - 1) / 2) * SHELF_SIZE[0]
        at = np.array([x, SHELF_SIZE[1] / 2, SHELF_SIZE[2] / 2])
        draft.add("shelf_bay", T_world_row @ make_transform(translation=at))
        for top in shelf_tops()[:-1]:
            T_world_shelf = T_world_row @ make_transform(translation=np.array([x, 0.0, top]))
            is_own = own_fraction > 0.0 and bool(rng.random() < own_fraction)
            if not is_own:
                _fill_shelf(draft, T_world_shelf, fill, rng)
            strips.append(Strip(T_world_shelf, _CLEAR, _DEPTH, SHELF_CLEARANCE, fill if is_own else 0.0))
    return strips


def _fill_shelf(draft: SceneDraft, T_world_shelf: Transform, fill: float, rng: np.random.Generator) -> None:
    """Put things of one kind side by side, short side out where they are longer than wide."""
    kinds = _kinds()
    models = kinds[int(rng.integers(len(kinds)))]
    model = models[int(rng.integers(len(models)))]
    turned = model.size[0] > model.size[1] and model.size[0] <= SHELF_SIZE[1] - 0.06
    width, depth = (model.size[1], model.size[0]) if turned else (model.size[0], model.size[1])
    x = -_CLEAR / 2 + rng.uniform(*_PLAY)
    setback = rng.uniform(*_BEHIND_EDGE)
    while x + width <= _CLEAR / 2:
        if rng.random() < fill:
            shown = models[int(rng.integers(len(models)))] if len({item.size[1] for item in models}) == 1 else model
            at = np.array([x + width / 2, setback + depth / 2 + rng.uniform(0.0, 0.01), model.size[2] / 2])
            draft.add(shown.name, T_world_shelf @ make_transform(_QUARTER_TURN if turned else None, at))
        x += width + rng.uniform(*_PLAY)


@cache
def _kinds() -> list[list[ObjectModel]]:
    """Return the kinds of things that fit a shelf: bins twice, as they are the rule, containers, cartons."""
    height = SHELF_CLEARANCE - 0.03

    def fitting(names: list[str]) -> list[list[ObjectModel]]:
        models = [catalog_object(name) for name in names]
        return [[model] for model in models if min(model.size[:2]) <= 0.41 and model.size[2] <= height]

    bins = [[catalog_object(name)] for name in BINS]
    small = [name for name in (*TOTES, *SKUS) if max(catalog_object(name).size[:2]) <= 0.46]
    return [*bins, *bins, *fitting(small)]
