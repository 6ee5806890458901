import hashlib
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.generation.light.floor_walks import floor_lux_by_walks
from warehouse_sim.errors import RecipeError
from warehouse_sim.generation.light import LightMeter, light_scene, measure_conditions, target_illuminance
from warehouse_sim.generation.light.meter import spread_pixels
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import sample_settled_scene
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene import Distribution
from warehouse_sim.scene.lighting.config import PRESETS, LightingConfig
from warehouse_sim.scene.lighting.exposure import ExposureConfig, exposure_of_ev
from warehouse_sim.schema import SceneChange, SceneSpec

CAMERA = PinholeCamera.from_focal(612, 185, 361.0)


@cache
def settled(recipe: str) -> tuple[SceneSpec, RayCaster]:
    fewer = {"scene": {"layout": {"doors": 3}}} if recipe == "dock_staging" else None
    scene = sample_settled_scene(load_recipe(recipe, fewer), 0, 0).scene
    return scene, RayCaster(scene)


@cache
def lit(recipe: str, preset: str, **settings: object) -> SceneSpec:
    scene, caster = settled(recipe)
    config = LightingConfig(preset=preset, **settings)  # type: ignore[arg-type]
    return light_scene(scene, config, caster, CAMERA, np.random.default_rng(0))


def geometry_hash(scene: SceneSpec) -> str:
    """Of everything that has a place: meshes, instances, collision boxes and the poses of the viewpoints."""
    digest = hashlib.sha256()
    for name, model in scene.models.items():
        digest.update(f"{name} {model.class_name} {model.obj_id}".encode())
        for part in model.parts:
            digest.update(part.mesh.vertices.tobytes() + part.mesh.faces.tobytes())
            digest.update(part.scale.tobytes() + part.T_object_part.tobytes() + part.material.encode())
        for box in model.collision:
            digest.update(box.T_parent_box.tobytes() + box.size.tobytes())
    for item in scene.instances:
        digest.update(f"{item.instance_id} {item.model} {item.dynamic} {item.group}".encode())
        digest.update(item.T_world_object.tobytes())
    for view in scene.viewpoints:
        digest.update(view.T_world_camera.tobytes())
    return digest.hexdigest()


@pytest.mark.parametrize(
    ("recipe", "preset"),
    [
        *[("demo", preset) for preset in PRESETS],
        pytest.param("conveyor_pickup", "night", marks=pytest.mark.slow),
        ("dock_staging", "nominal"),
    ],
)
def test_the_floor_gets_the_wanted_lux(recipe: str, preset: str) -> None:
    scene, caster = lit(recipe, preset), settled(recipe)[1]
    wanted = PRESETS[preset].lux  # type: ignore[index]
    measured = LightMeter(scene, caster).floor_lux
    assert wanted.low * 0.999 <= measured <= wanted.high * 1.001
    assert floor_lux_by_walks(scene, caster, 2000, np.random.default_rng(7)) == pytest.approx(measured, rel=0.10)
    requested = lit(recipe, preset, lux=Distribution.constant(77.0))
    assert LightMeter(requested, caster).floor_lux == pytest.approx(77.0, rel=0.01)


@pytest.mark.parametrize("recipe", ["demo", pytest.param("dock_staging", marks=pytest.mark.slow)])
def test_another_preset_moves_nothing(recipe: str) -> None:
    scenes = [lit(recipe, preset) for preset in PRESETS]
    assert {geometry_hash(scene) for scene in scenes} == {geometry_hash(settled(recipe)[0])}
    assert [scene.lighting for scene in scenes] == list(PRESETS)
    assert len({tuple(light.intensity for light in scene.lights) for scene in scenes}) == len(PRESETS)


def test_the_light_of_a_scene_repeats() -> None:
    scene, caster = settled("demo")
    for preset in ("failing", "night"):
        again = light_scene(scene, LightingConfig(preset=preset), caster, CAMERA, np.random.default_rng(0))
        first = lit("demo", preset)
        assert again.materials == first.materials
        assert [view.exposure for view in again.viewpoints] == [view.exposure for view in first.viewpoints]
        for one, other in zip(again.lights, first.lights, strict=True):
            assert one.intensity == other.intensity


def test_given_flux_takes_the_lux_that_it_gives() -> None:
    scene, caster = settled("demo")
    lights = lit("demo", "nominal", flux=Distribution.constant(9000.0)).lights
    twice = lit("demo", "nominal", flux=Distribution.constant(18000.0))
    assert [light.intensity for light in twice.lights] == pytest.approx([2 * light.intensity for light in lights])
    one = LightMeter(lit("demo", "nominal", flux=Distribution.constant(9000.0)), caster).floor_lux
    assert LightMeter(twice, caster).floor_lux == pytest.approx(2 * one)
    assert scene.settled


def test_only_at_night_each_viewpoint_has_its_vehicles_lights() -> None:
    for preset in PRESETS:
        lights = [len(view.lights) for view in lit("demo", preset).viewpoints]
        assert set(lights) == ({2} if preset == "night" else {0})
    night = lit("demo", "night")
    places = {view.lights[0].position.tobytes() for view in night.viewpoints}
    assert len(places) == len(night.viewpoints)


def test_exposure_is_metered_for_each_view_or_fixed() -> None:
    assert len({view.exposure for view in lit("demo", "nominal").viewpoints}) > 5
    fixed = lit("demo", "nominal", exposure=ExposureConfig("fixed", ev=6.5))
    assert {view.exposure for view in fixed.viewpoints} == {exposure_of_ev(6.5)}
    meter = LightMeter(fixed, settled("demo")[1])
    conditions = measure_conditions(meter, fixed.viewpoints[0])
    assert conditions.exposure_ev == pytest.approx(6.5)
    assert conditions.floor_lux == meter.floor_lux
    assert conditions.lighting == "nominal"
    # Twice the light, one stop less exposure.
    low, high = (lit("demo", "nominal", lux=Distribution.constant(lux)) for lux in (100.0, 200.0))
    for before, after in zip(low.viewpoints, high.viewpoints, strict=True):
        assert before.exposure is not None
        assert after.exposure == pytest.approx(before.exposure / 2, rel=1e-6)


@pytest.mark.parametrize("preset", ["failing", "night"])
def test_the_light_of_a_viewpoint_does_not_depend_on_the_scenes_other_viewpoints(preset: str) -> None:
    scene, caster = settled("demo")
    config, every = LightingConfig(preset=preset), lit("demo", preset)  # type: ignore[arg-type]
    for number in (0, 7):
        alone = replace(scene, viewpoints=scene.viewpoints[number : number + 1])
        alone = light_scene(alone, config, caster, CAMERA, np.random.default_rng(0))
        one, other = alone.seen_from(alone.viewpoints[0]), every.seen_from(every.viewpoints[number])
        assert one.exposure == other.exposure
        assert one.materials == other.materials
        assert not SceneChange.between(one, other).lights


def test_a_targets_illuminance_is_that_of_the_surface_that_is_seen() -> None:
    scene, caster = settled("demo")
    view = scene.viewpoints[0]
    directions = CAMERA.rays().reshape(-1, 3) @ view.T_world_camera[:3, :3].T
    hits = caster.cast(np.tile(view.T_world_camera[:3, 3], (len(directions), 1)), directions)
    ids = hits.instance_ids.reshape(CAMERA.height, CAMERA.width)
    targets = [item.instance_id for item in scene.target_instances() if (ids == item.instance_id).sum() > 20]
    assert len(targets) > 2
    measured = {}
    for lux in (100.0, 300.0):
        bright = lit("demo", "nominal", lux=Distribution.constant(lux))
        measured[lux] = target_illuminance(LightMeter(bright, caster), view, CAMERA, ids, targets)
        assert list(measured[lux]) == targets
        # A pallet in or before the rack gets less than the free floor, which faces the lights, but is not dark.
        assert all(0.02 * lux < value < 1.3 * lux for value in measured[lux].values())
    for target in targets:
        assert measured[300.0][target] == pytest.approx(3 * measured[100.0][target], rel=1e-6)
    hidden = max(item.instance_id for item in scene.instances) + 1
    assert target_illuminance(LightMeter(scene, caster), view, CAMERA, ids, [hidden]) == {}
    assert target_illuminance(LightMeter(scene, caster), view, CAMERA, ids, []) == {}


def test_pixels_of_targets_are_spread_over_each_of_them_alone() -> None:
    ids = np.zeros((60, 90), np.int32)
    ids[6:40, 9:50], ids[10:30, 20:30], ids[1:3, 1:4], ids[59, 89] = 7, 900, 5, 3
    targets = [900, 3, 5, 7, 8]
    for target, pixels in zip(targets, spread_pixels(ids, targets), strict=True):
        coarse, every = np.argwhere(ids[::3, ::3] == target) * 3, np.argwhere(ids == target)
        found = coarse if len(coarse) >= 12 else every
        count = min(len(found), 12)
        assert np.array_equal(pixels, found[np.linspace(0, len(found) - 1, count).round().astype(int)])


def test_a_hall_without_luminaires_over_its_aisle_is_rejected() -> None:
    scene, _ = settled("demo")
    luminaires = {item.instance_id for item in scene.instances if scene.model_of(item).class_name == "luminaire"}
    bare = replace(scene, instances=tuple(item for item in scene.instances if item.instance_id not in luminaires))
    with pytest.raises(RecipeError, match="no light reaches the aisle's floor"):
        light_scene(bare, LightingConfig(), RayCaster(bare), CAMERA, np.random.default_rng(0))
