"""A recipe is sampled once a scene, and what was sampled travels with the scene."""

from collections import Counter

import pytest

from warehouse_sim.config import from_mapping
from warehouse_sim.generation.recipe import Recipe
from warehouse_sim.generation.scene import prepare_scene, sample_settled_scene
from warehouse_sim.scene.random_settings import RandomSetting

OPEN = {
    "layout": {"kind": "rack_aisle", "bays": {"min": 1, "max": 3}, "beam_levels": [1.5]},
    "hall": {"tyre_marks": {"min": 0, "max": 6}},
    "viewpoints": {"clearance": {"min": 0.4, "max": 0.6}},
    "observations_per_scene": 2,
}
RECIPE = from_mapping(Recipe, {"description": "open settings", "name": "open", "scene": OPEN}, "open.yaml")


def test_each_open_setting_is_drawn_once_a_scene(monkeypatch: pytest.MonkeyPatch) -> None:
    draws, draw = Counter[str](), RandomSetting.sample
    monkeypatch.setattr(RandomSetting, "sample", lambda self, rng: draws.update([self.name]) or draw(self, rng))
    scene = prepare_scene(RECIPE, 0, 0).scene
    assert scene.attempt == 0
    assert draws == {"layout.bays": 1, "hall.tyre_marks": 1, "viewpoints.clearance": 1}


def test_what_was_drawn_is_what_the_scene_was_built_from() -> None:
    bays = set()
    for index in range(4):
        sampled = sample_settled_scene(RECIPE, 0, index)
        assert sampled.settings.random_settings == ()
        frames = [item for item in sampled.scene.instances if item.model.startswith("rack_frame")]
        assert len(frames) == sampled.settings.layout.to_plain()["bays"] + 1
        bays.add(len(frames))
    assert len(bays) > 1


def test_streams_of_later_stages_follow_the_attempt() -> None:
    sampled = sample_settled_scene(RECIPE, 3, 1)
    assert sampled.stream("light").random() == sampled.stream("light").random() != sampled.stream("other").random()
