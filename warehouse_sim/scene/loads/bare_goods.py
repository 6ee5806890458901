"""Goods that stand without a pallet: articles of the user's own on shelves and conveyors, cartons on conveyors.

They rest by construction on level surfaces and are fixed.
"""

from collections.abc import Sequence

import numpy as np

from warehouse_sim.catalog import catalog_object
from warehouse_sim.errors import PlacementError
from warehouse_sim.geometry.pose import make_transform, rotation_z
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.layouts.site import Strip
from warehouse_sim.scene.packing.load_config import UnitLoadConfig
from warehouse_sim.schema import ObjectModel

_PLAY = (0.005, 0.05)
"""Least and largest gap between two pieces (m)."""
_BEHIND_EDGE = (0.01, 0.04)
"""How far behind the front edge of a shelf pieces stand (m), where it is deep enough."""
_YAW = 0.02
"""Largest turn of a piece about the vertical (rad)."""
_OVER = 0.01
"""Least air above a piece (m)."""

Way = tuple[ObjectModel, bool]
"""An article and whether it stands turned by a quarter."""


def stock_strips(draft: SceneDraft, strips: Sequence[Strip], loads: UnitLoadConfig, rng: np.random.Generator) -> None:
    """Put goods side by side on the strips that wait for them.

    Args:
        draft: Where to add them.
        strips: Shelves and conveyors; those whose ``fill`` is 0 are left as they are.
        loads: What the recipe says of goods and cartons.
        rng: Stream to draw from.

    Raises:
        PlacementError: Nothing that the recipe lists fits a strip.
    """
    for strip in strips:
        if strip.fill > 0.0:
            own, cartons = _that_fit(loads.goods, strip), _that_fit(loads.cartons, strip)
            _stock(draft, strip, own, cartons, rng)


def _that_fit(names: Sequence[str], strip: Strip) -> list[Way]:
    """Return the articles that a strip has room for, as they stand: short side out where there is a choice."""
    ways = []
    for name in names:
        model = catalog_object(name)
        length, width, height = model.size.tolist()
        deep_enough = strip.depth - 2 * _BEHIND_EDGE[0]
        across = [turned for turned in (length > width, length <= width) if _depth(model, turned) <= deep_enough]
        if across and height <= strip.headroom - _OVER:
            ways.append((model, across[0]))
    return ways


def _stock(draft: SceneDraft, strip: Strip, own: list[Way], cartons: list[Way], rng: np.random.Generator) -> None:
    """Fill one strip from one end to the other, with gaps where nothing stands."""
    x, chosen = -strip.length / 2 + rng.uniform(*_PLAY), None
    while True:
        if chosen is None or not strip.one_kind:
            kinds = own if rng.random() < strip.own_fraction else cartons
            if not kinds:
                listed = "goods" if kinds is own else "cartons"
                raise PlacementError(
                    f"nothing of loads.{listed} fits a surface {strip.depth:.2f} m deep with {strip.headroom:.2f} m of "
                    "free height; list something smaller or lower layout.goods_fraction"
                )
            chosen = kinds[int(rng.integers(len(kinds)))]
        model, turned = chosen
        width, depth, yaw = _depth(model, not turned), _depth(model, turned), rng.uniform(-_YAW, _YAW)
        # What a turn adds to both edges.
        width, depth = width + abs(yaw) * depth, depth + abs(yaw) * width
        if x + width > strip.length / 2:
            return
        if rng.random() < strip.fill and depth <= strip.depth:
            setback = min(float(rng.uniform(*_BEHIND_EDGE)), strip.depth - depth)
            at = np.array([x + width / 2, setback + depth / 2, model.size[2] / 2])
            T_strip_piece = make_transform(rotation_z(yaw + (np.pi / 2 if turned else 0.0)), at)
            draft.add(model, strip.T_world_strip @ T_strip_piece)
        x += width + rng.uniform(*_PLAY)


def _depth(model: ObjectModel, turned: bool) -> float:
    """Return the edge (m) that points away from the front."""
    return float(model.size[0] if turned else model.size[1])
