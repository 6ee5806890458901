"""Runs go on where they stopped, and see what the package's own images show."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from warehouse_sim.benchmark.docking.closed_loop import run as run_module
from warehouse_sim.benchmark.docking.closed_loop.perceive import LiveScene
from warehouse_sim.benchmark.docking.closed_loop.run import Runner
from warehouse_sim.benchmark.docking.closed_loop.settings import BASE, CONDITIONS, DRIFTS
from warehouse_sim.benchmark.docking.record import Kept
from warehouse_sim.generation.observe import Stage
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.recipe.paired_variants import base_variant
from warehouse_sim.generation.scene import sample_settled_scene
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.render import open_renderer
from warehouse_sim.scene.lighting.config import PRESETS as LIGHTS
from warehouse_sim.sensors.rgbd.depth.models import MODELS, PRESETS


def test_every_level_changes_one_factor_of_the_base_and_names_what_there_is() -> None:
    for name, item in CONDITIONS.items():
        assert item.name == name
        assert item.light in LIGHTS
        assert item.sensor in ("own", *MODELS, *PRESETS)
        assert item.drift in DRIFTS
        changed = [key for key in ("light", "visible", "sensor", "is_open") if getattr(item, key) != getattr(BASE, key)]
        assert len(changed) <= 1
        assert (item == BASE) == (name == "base")


def test_a_run_goes_on_where_it_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "episodes.jsonl"
    one = Runner("smoke", 3, (BASE, CONDITIONS["open loop"]), None, Kept(file), {}, {}, starts=1)
    rows = list(one.rows(1))
    assert [(row["condition"], row["method"]) for row in rows] == [("base", "oracle"), ("open loop", "oracle")]
    assert rows[0]["outcome"] == "docked"
    assert rows[1]["images"] == 1
    with file.open("a") as open_file:
        open_file.write('{"key": "half a li')

    def never(*_: object) -> None:
        raise AssertionError("a scene was drawn again")

    monkeypatch.setattr(run_module, "sample_settled_scene", never)
    again = Runner("smoke", 3, (BASE, CONDITIONS["open loop"]), None, Kept(file), {}, {}, starts=1)
    assert list(again.rows(1)) == rows
    other = Runner("smoke", 3, (CONDITIONS["no drift"],), None, Kept(file), {}, {}, starts=1)
    with pytest.raises(AssertionError, match="drawn again"):
        list(other.rows(1))
    assert all(json.loads(line)["key"] for line in file.read_text().splitlines()[:-1])


@pytest.mark.gl
def test_a_live_image_shows_what_an_observation_from_there_shows_and_changes_with_light_and_place() -> None:
    recipe = load_recipe("smoke")
    sampled = sample_settled_scene(recipe, 3, 0)
    viewpoint = sampled.scene.viewpoints[0]
    aside = replace(viewpoint, T_world_camera=viewpoint.T_world_camera @ make_transform(None, np.array([0.2, 0, 0])))
    with open_renderer("raster") as renderer:
        live = LiveScene(recipe, sampled, renderer, "nominal", "ideal")
        shot = live.shoot(viewpoint, 0.0, "some noise")
        again = live.shoot(viewpoint, 0.0, "some noise")
        stage = Stage(renderer, recipe.sensors.make_camera())
        moment, _ = stage.set_up(base_variant(sampled.scene, live.choice), 0, viewpoint)
        buffers = moment.images.seen_from(viewpoint.T_world_camera)
        day = LiveScene(recipe, sampled, renderer, "nominal", "own")
        first, moved = day.shoot(viewpoint, 0.0, "a"), day.shoot(aside, 0.2, "b")
        night = LiveScene(recipe, sampled, renderer, "night", "own").shoot(viewpoint, 0.0, "a")
    np.testing.assert_array_equal(shot.instance_mask, buffers.instance_mask)
    read = shot.depth > 0.0
    assert read.mean() > 0.5
    np.testing.assert_allclose(shot.depth[read], buffers.depth[read], atol=1e-3)
    np.testing.assert_array_equal(shot.depth, again.depth)
    np.testing.assert_array_equal(shot.rgb, again.rgb)
    assert shot.rgb.std() > 5.0
    assert (first.instance_mask != moved.instance_mask).mean() > 0.01
    np.testing.assert_array_equal(first.instance_mask, night.instance_mask)
    # The work lights reach the middle, not the edges.
    assert np.percentile(night.rgb, 10) < 0.5 * np.percentile(first.rgb, 10)
