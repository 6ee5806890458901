"""Layouts that bring their own goods: all of them lie on something, none in anything."""

import numpy as np
import pytest

from tests.scene.sites import built
from warehouse_sim.scene.layouts.cantilever import CantileverConfig
from warehouse_sim.scene.layouts.mezzanine import MezzanineConfig
from warehouse_sim.scene.layouts.site import Layout
from warehouse_sim.scene.layouts.small_parts import SmallPartsConfig
from warehouse_sim.scene.loads.resting import drop_to_rest

GOODS = ("long_goods", "bin", "tote", "carton")
LAYOUTS: tuple[Layout, ...] = (
    CantileverConfig(fields=8, levels=5, sides="both"),
    SmallPartsConfig(bays=3, rows=3, sides="both"),
    MezzanineConfig(panels=2, panel_rows=2),
)


@pytest.mark.parametrize("layout", LAYOUTS, ids=lambda layout: layout.kind)
@pytest.mark.parametrize("seed", [0, 1])
def test_goods_rest_on_what_is_under_them(layout: Layout, seed: int) -> None:
    draft, _ = built(layout, seed)
    solids = draft.solids()
    goods = [item for item in draft.instances if draft.models[item.model].class_name in GOODS]
    assert len(goods) > 20
    for item in goods:
        mine = solids.of_objects([item.instance_id])
        near = solids.near(*solids.extent_of([item.instance_id]), 0.05) & ~mine
        drop = drop_to_rest(solids.boxes.subset(mine), solids.boxes.subset(near))
        assert drop == pytest.approx(0.0, abs=1e-9), item.model


@pytest.mark.parametrize("layout", LAYOUTS, ids=lambda layout: layout.kind)
def test_nothing_is_inside_something_else(layout: Layout) -> None:
    draft, _ = built(layout)
    solids = draft.solids()
    kind = {item.instance_id: draft.models[item.model].class_name for item in draft.instances}
    pairs = solids.boxes.pairs(solids.boxes)
    pairs = pairs[solids.owner[pairs[:, 0]] < solids.owner[pairs[:, 1]]]
    deep = solids.boxes.separation(solids.boxes, pairs).distance < -1e-6
    found = {frozenset((kind[solids.owner[a]], kind[solids.owner[b]])) for a, b in pairs[deep]}
    building = {"wall", "floor", "column"}
    assert not {pair for pair in found if not pair <= building}


def test_long_goods_lie_on_two_arms_or_more() -> None:
    draft, _ = built(LAYOUTS[0], 2)
    arms = [item.T_world_object[0, 3] for item in draft.instances if item.model.startswith("cantilever_column")]
    for item in draft.instances:
        model = draft.models[item.model]
        if model.class_name == "long_goods":
            away = np.abs(np.unique(np.round(arms, 6)) - item.T_world_object[0, 3])
            assert np.count_nonzero(away < model.size[0] / 2 - 0.05) >= 2, item.model
