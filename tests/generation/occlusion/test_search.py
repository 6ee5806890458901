"""A search is told all it needs when it is made, and returns all that it found."""

from dataclasses import replace

import numpy as np

from tests.generation.occlusion.scenes import VIEW, hall, occluded_scene_of
from warehouse_sim.generation.occlusion.config import FractionRange, OcclusionConfig, VisibleFractions
from warehouse_sim.generation.occlusion.occluded_scene import OccludedScene
from warehouse_sim.generation.occlusion.occluder import OccluderSampler
from warehouse_sim.generation.occlusion.search import Request, RequestedView, Search
from warehouse_sim.scene.loads.unit_load import UnitLoadConfig
from warehouse_sim.scene.viewpoints.config import ViewpointsConfig

CONFIG = OcclusionConfig(VisibleFractions((FractionRange(0.3, 0.6),)), kinds=("traffic",))


def search(occluded: OccludedScene, request: Request, previous_views: list[RequestedView | None]) -> Search:
    rng = np.random.default_rng(5)
    sampler = OccluderSampler(UnitLoadConfig(), rng)
    return Search(occluded, request, VIEW, ViewpointsConfig(), CONFIG, sampler, (), rng, (), previous_views)


def test_a_search_returns_its_view_after_those_before_it_and_leaves_what_it_was_given() -> None:
    occluded = occluded_scene_of(hall())
    clear = search(occluded, Request(0.9, 1.0), []).run()
    assert [view is not None and view.met for view in clear.views] == [True]
    before = list(clear.views)
    hidden = search(occluded, Request(0.3, 0.6), before).run()
    assert before == list(clear.views)
    assert len(hidden.views) == 2
    assert hidden.views[1] is not None
    assert hidden.views[1].met
    assert hidden.views[1].means == "traffic"
    assert hidden.tries >= 1
    # The view before is as it is now: it was hidden no further than it may be.
    assert hidden.views[0] is not None
    assert hidden.views[0].met


def test_a_view_that_shows_no_target_is_none_and_says_why() -> None:
    occluded = occluded_scene_of(hall())
    away = replace(VIEW, T_world_camera=VIEW.T_world_camera @ np.diag([-1.0, 1.0, -1.0, 1.0]), sequence=0)
    answer = replace(search(occluded, Request(0.3, 0.6), [None]), own=away).run()
    assert answer.views == (None, None)
    assert answer.reason == "no free place to look from"
