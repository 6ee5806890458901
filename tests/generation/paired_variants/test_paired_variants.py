"""Paired variants differ in what was changed, and in nothing else: to the last bit."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import ConfigError
from warehouse_sim.generation.observe import observe_scene
from warehouse_sim.generation.recipe import Recipe, load_recipe
from warehouse_sim.generation.recipe.paired_variants import PairedVariantsConfig, make_variants
from warehouse_sim.generation.scene import prepare_scene, sample_settled_scene
from warehouse_sim.render import Renderer
from warehouse_sim.schema import Observation, SceneSpec
from warehouse_sim.sensors.rig import CameraConfig, SensorChoice

pytestmark = pytest.mark.gl

PLAIN = {
    "lights": [{"name": "half", "factor": 0.5}],
    "materials": [{"name": "other surfaces", "swap": {"kraft": "board_white", "concrete": "blockwork"}}],
    "noise": [{"name": "again"}, {"name": "coarse", "rgbd": {"depth": {"sigma_base": 0.2}}, "sample": 0}],
    "without_occluders": True,
}


def dimmed(scene: SceneSpec, settings: dict[str, Any]) -> SceneSpec:
    lights = tuple(replace(light, intensity=light.intensity * settings["factor"]) for light in scene.lights)
    return replace(scene, lights=lights, lighting="half")


@pytest.fixture(scope="module")
def made(renderer: Renderer) -> tuple[int, dict[str, list[Observation]]]:
    """Return the id of the object that counts as the occluder, and the observations of each variant."""
    recipe = load_recipe("smoke")
    camera = CameraConfig(width=612, height=185, focal_px=360.0)
    recipe = replace(recipe, sensors=replace(recipe.sensors, camera=camera))
    scene = sample_settled_scene(recipe, 0, 0).scene
    occluder = next(item.instance_id for item in scene.instances if scene.model_of(item).class_name == "carton")
    occluders = [(occluder,), *(() for _ in scene.viewpoints[1:])]
    variants = make_variants(
        scene,
        from_mapping(PairedVariantsConfig, PLAIN, "paired_variants"),
        SensorChoice("", recipe.sensors.rgbd),
        occluders,
        dimmed,
    )
    found: dict[str, list[Observation]] = {variant.name: [] for variant in variants}
    for number, observation in enumerate(observe_scene(scene, recipe.sensors, renderer, variants)):
        assert observation.observation_index == number
        found[observation.conditions.variant].append(observation)
    assert {len(items) for items in found.values()} == {len(scene.viewpoints)}
    return occluder, found


def pairs(found: dict[str, list[Observation]], name: str) -> list[tuple[Observation, Observation]]:
    return list(zip(found["base"], found[name], strict=True))


def test_paired_variants_share_group_place_and_poses(made: tuple[int, dict[str, list[Observation]]]) -> None:
    _, found = made
    for name in found:
        for group, (first, paired_variant) in enumerate(pairs(found, name)):
            assert first.conditions.variant_group == paired_variant.conditions.variant_group == group
            assert np.array_equal(first.T_world_camera, paired_variant.T_world_camera)
            poses = {item.instance_id: item.T_camera_object for item in first.annotations}
            for label in paired_variant.annotations:
                if label.instance_id in poses:
                    assert np.array_equal(label.T_camera_object, poses[label.instance_id])


@pytest.mark.parametrize("name", ["half", "other surfaces", "again", "coarse"])
def test_what_is_there_is_the_same_but_for_the_occluder(
    made: tuple[int, dict[str, list[Observation]]], name: str
) -> None:
    for first, paired_variant in pairs(made[1], name):
        assert np.array_equal(first.buffers.depth, paired_variant.buffers.depth)
        assert np.array_equal(first.buffers.instance_mask, paired_variant.buffers.instance_mask)
        for a, b in zip(first.annotations, paired_variant.annotations, strict=True):
            assert (a.instance_id, a.pixels_visible, a.pixels_all) == (b.instance_id, b.pixels_visible, b.pixels_all)
            assert np.array_equal(a.amodal_mask, b.amodal_mask)
        assert first.lidar is not None
        assert paired_variant.lidar is not None
        if name != "other surfaces":
            assert np.array_equal(first.lidar.points, paired_variant.lidar.points)


def test_another_light_changes_the_colours_only(made: tuple[int, dict[str, list[Observation]]]) -> None:
    for first, paired_variant in pairs(made[1], "half"):
        assert np.array_equal(first.rgbd.depth, paired_variant.rgbd.depth)
        assert first.lidar is not None
        assert paired_variant.lidar is not None
        assert np.array_equal(first.lidar.intensity, paired_variant.lidar.intensity)
        assert paired_variant.buffers.rgb.mean() < 0.9 * first.buffers.rgb.mean()
        assert paired_variant.conditions.lighting == "half"


def test_another_surface_changes_colours_and_remission(made: tuple[int, dict[str, list[Observation]]]) -> None:
    changed = 0
    for first, paired_variant in pairs(made[1], "other surfaces"):
        assert np.array_equal(first.rgbd.depth, paired_variant.rgbd.depth)
        changed += not np.array_equal(first.buffers.rgb, paired_variant.buffers.rgb)
        # The same noise on the same beams; a weaker echo scatters a little more and is missed more often. Both are
        # matt: a coated floor would throw on what meets it at a grazing angle.
        assert first.lidar is not None
        assert paired_variant.lidar is not None
        beams = [item.lidar.ring + 1j * item.lidar.time for item in (first, paired_variant)]
        common, seen, again = np.intersect1d(*beams, return_indices=True)
        assert len(common) > 0.99 * len(first.lidar.points)
        moved = np.linalg.norm(first.lidar.points[seen] - paired_variant.lidar.points[again], axis=1)
        assert np.quantile(moved, 0.99) < 0.005
    assert changed == len(made[1]["base"])


def test_other_noise_changes_the_reading_only(made: tuple[int, dict[str, list[Observation]]]) -> None:
    for first, paired_variant in pairs(made[1], "again"):
        assert np.array_equal(first.buffers.rgb, paired_variant.buffers.rgb)
        assert not np.array_equal(first.rgbd.depth, paired_variant.rgbd.depth)
    for first, paired_variant in pairs(made[1], "coarse"):
        read = (first.rgbd.depth > 0) & (paired_variant.rgbd.depth > 0)
        error, coarse = (np.std((item.rgbd.depth - item.buffers.depth)[read]) for item in (first, paired_variant))
        assert coarse > 1.5 * error


def test_without_the_occluder_its_pixels_show_what_is_behind(made: tuple[int, dict[str, list[Observation]]]) -> None:
    occluder, found = made
    (first, paired_variant), *others = pairs(found, "without occluders")
    assert paired_variant.conditions.absent == (occluder,)
    gone = first.buffers.instance_mask == occluder
    assert gone.any()
    assert not (paired_variant.buffers.instance_mask == occluder).any()
    assert np.array_equal(first.buffers.instance_mask[~gone], paired_variant.buffers.instance_mask[~gone])
    assert np.array_equal(first.buffers.depth[~gone], paired_variant.buffers.depth[~gone])
    assert (paired_variant.buffers.depth[gone] >= first.buffers.depth[gone]).all()
    for mine, theirs in others:
        assert theirs.conditions.absent == ()
        assert_same(mine, theirs)


def assert_same(first: Observation, paired_variant: Observation) -> None:
    """Nothing was put there for this view: all that is read of it and said of it is the same."""
    assert np.array_equal(first.buffers.rgb, paired_variant.buffers.rgb)
    assert np.array_equal(first.rgbd.rgb, paired_variant.rgbd.rgb)
    assert np.array_equal(first.rgbd.depth, paired_variant.rgbd.depth)
    assert np.array_equal(first.buffers.instance_mask, paired_variant.buffers.instance_mask)
    assert first.lidar is not None
    assert paired_variant.lidar is not None
    assert np.array_equal(first.lidar.points, paired_variant.lidar.points)


def test_only_what_a_views_own_request_put_there_is_gone(renderer: Renderer) -> None:
    """A scene of requests: outside of what is taken away no depth and no id changes, whatever others were given."""
    plain = to_mapping(load_recipe("smoke"))
    plain["scene"]["observations_per_scene"] = 4
    plain |= {
        "sensors": {"camera": {"width": 320, "height": 120, "focal_px": 190}, "lidar": None},
        "occlusion": {"visible_fraction": [{"min": 0.4, "max": 0.6}, {"min": 0.1, "max": 0.3}]},
        "paired_variants": {"without_occluders": True},
    }
    recipe = from_mapping(Recipe, plain, "here")
    prepared = prepare_scene(recipe, 0, 0)
    assert prepared.occlusion is not None
    placed = [set(item.placed) for item in prepared.occlusion.requests]
    assert sum(map(bool, placed)) >= 2, "the scene must hold the occluders of several views"
    seen = list(observe_scene(prepared.scene, recipe.sensors, renderer, prepared.variants))
    count, uncovered = len(placed), 0
    others = 0
    for first, paired_variant, own in zip(seen[:count], seen[count:], placed, strict=True):
        assert set(paired_variant.conditions.absent) == own
        gone = np.isin(first.buffers.instance_mask, list(own))
        uncovered += np.count_nonzero(gone)
        assert np.count_nonzero((first.buffers.depth != paired_variant.buffers.depth) & ~gone) == 0
        assert np.count_nonzero((first.buffers.instance_mask != paired_variant.buffers.instance_mask) & ~gone) == 0
        assert not np.isin(paired_variant.buffers.instance_mask, list(own)).any()
        others += np.isin(paired_variant.buffers.instance_mask, list(set().union(*placed) - own)).sum()
    assert uncovered > 0
    assert others > 0, "what was put there for another view must stay"


def test_the_config_comes_back_from_plain_data_and_rejects_what_makes_no_paired_variant() -> None:
    config = from_mapping(PairedVariantsConfig, PLAIN, "paired_variants")
    assert from_mapping(PairedVariantsConfig, to_mapping(config), "paired_variants") == config
    assert config.names() == ("base", "without occluders", "half", "other surfaces", "again", "coarse")
    for plain, message in (
        ({"noise": [{"name": "a"}, {"name": "a"}]}, "a name of its own"),
        ({"noise": [{"name": ""}]}, r"found \['base', ''\]$"),
        ({"noise": [{"name": "a", "sample": 0}]}, "sample must be >= 1"),
        ({"lights": [{"preset": "dim"}]}, "expected a name"),
        ({"materials": [{"name": "x", "swap": {"wood": "kraft"}}]}, "swap names 'wood'"),
        ({"materials": [{"name": "x", "swap": {"kraft": "stretch_film"}}]}, "is film"),
    ):
        with pytest.raises(ConfigError, match=message):
            from_mapping(PairedVariantsConfig, plain, "paired_variants")
