"""Requests in whole scenes."""

from dataclasses import replace

import numpy as np
import pytest

from tests.generation.occlusion.scenes import CAMERA, hall, on_floor
from warehouse_sim.annotate import annotate
from warehouse_sim.errors import PlacementError
from warehouse_sim.generation.occlusion import (
    FractionRange,
    OcclusionConfig,
    OcclusionReport,
    VisibleFractions,
    request_views,
)
from warehouse_sim.generation.recipe import Recipe, load_recipe
from warehouse_sim.generation.scene import sample_settled_scene
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.physics.check import contact_state
from warehouse_sim.render import Renderer
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.recipe import SceneRecipe
from warehouse_sim.scene.streams import scene_rng
from warehouse_sim.scene.viewpoints.config import ViewpointsConfig
from warehouse_sim.scene.viewpoints.free_space import vehicle_boxes
from warehouse_sim.schema import SceneSpec, Viewpoint

RANGES = ((0.7, 0.9), (0.4, 0.6), (0.1, 0.3))
CONFIG = OcclusionConfig(VisibleFractions(tuple(FractionRange(low, high) for low, high in RANGES)))
Requested = tuple[SceneSpec, SceneSpec, OcclusionReport]


def smoke(observations: int = 6) -> Recipe:
    recipe = load_recipe("smoke")
    return replace(recipe, scene=replace(recipe.scene, observations_per_scene=observations))


def requested(recipe: Recipe, config: OcclusionConfig, index: int = 0) -> Requested:
    sampled = sample_settled_scene(recipe, 0, index)
    scene, rng = sampled.scene, scene_rng(0, index, "occlusion")
    return scene, *request_views(scene, sampled.settings, recipe.sensors.make_camera(), config, RayCaster(scene), rng)


@pytest.fixture(scope="module")
def smoke_scene() -> Requested:
    return requested(smoke(), CONFIG)


def test_the_ranges_are_reached_in_turn(smoke_scene: Requested) -> None:
    _, scene, report = smoke_scene
    assert [(item.low, item.high) for item in report.requests] == [*RANGES, *RANGES]
    assert report.success_rate == 1.0
    assert not report.reasons
    for item, viewpoint in zip(report.requests, scene.viewpoints, strict=True):
        assert item.low <= item.reached <= item.high
        assert (viewpoint.target, viewpoint.visible_request) == (item.target, (item.low, item.high))
        assert 1 <= item.tries <= CONFIG.tries + 40


@pytest.mark.gl
def test_the_drawn_image_shows_the_fraction(smoke_scene: Requested, renderer: Renderer) -> None:
    _, scene, report = smoke_scene
    camera = smoke().sensors.make_camera()
    renderer.load(scene)
    for item, viewpoint in zip(report.requests, scene.viewpoints, strict=True):
        T, targets = viewpoint.T_world_camera, [x for x in scene.instances if x.instance_id == item.target]
        buffers = renderer.render(camera, T)
        amodal_masks = renderer.amodal_masks(camera, T, targets)
        (label,) = annotate(scene, camera, T, buffers, buffers.depth, amodal_masks, targets)
        assert item.low <= label.visible_fraction <= item.high
        assert label.visible_fraction == pytest.approx(item.reached, abs=0.006)
        assert max(label.hidden_by, key=lambda kind: label.hidden_by[kind]) == item.kind


def test_what_was_there_stays_and_what_is_new_stands_clear(smoke_scene: Requested) -> None:
    before, scene, report = smoke_scene
    assert scene.instances[: len(before.instances)] == before.instances
    new = scene.instances[len(before.instances) :]
    assert [item.instance_id for item in new] == [i for r in report.requests for i in r.placed]
    assert new, "no occluder was placed: the test shows nothing"
    assert {part.material for model in scene.models.values() for part in model.parts} <= set(scene.materials)
    assert not contact_state(scene).problems(max_overlap_mm=1.0, max_gap_mm=1.0)
    groups = {item.group for item in before.instances} - {0}
    assert groups.isdisjoint(item.group for item in new)
    solids = BoxStack.of([box for item in new for box in _boxes(scene, item.instance_id)])
    for viewpoint in scene.viewpoints:
        assert solids.distances_to(viewpoint.T_world_camera[:3, 3]).min() >= CONFIG.camera_clearance


def _boxes(scene: SceneSpec, instance_id: int) -> list[OrientedBox]:
    item = next(item for item in scene.instances if item.instance_id == instance_id)
    return [OrientedBox(item.T_world_object @ box.T_parent_box, box.size) for box in scene.model_of(item).collision]


def test_the_same_stream_gives_the_same_scene(smoke_scene: Requested) -> None:
    _, one, report = smoke_scene
    _, two, again = requested(smoke(), CONFIG)
    assert report == again
    assert len(one.instances) == len(two.instances)
    for a, b in zip(one.instances, two.instances, strict=True):
        assert (a.instance_id, a.model, a.group) == (b.instance_id, b.model, b.group)
        np.testing.assert_array_equal(a.T_world_object, b.T_world_object)
    for a, b in zip(one.viewpoints, two.viewpoints, strict=True):
        np.testing.assert_array_equal(a.T_world_camera, b.T_world_camera)


@pytest.mark.parametrize("kind", ["load", "wrap", "pallet", "traffic", "border"])
def test_one_kind_alone_can_be_requested_for(kind: str) -> None:
    config = replace(CONFIG, kinds=(kind,), visible_fraction=VisibleFractions((FractionRange(0.4, 0.6),)))  # type: ignore[arg-type]
    _, _, report = requested(smoke(3), config, index=1)
    assert report.success_rate == 1.0
    assert {item.means for item in report.requests} <= {kind, "view"}
    if kind == "wrap":
        # Film dims only: of a load in film the goods hide, or the pallet that they stand on. As film hides no view
        # to begin with, one that shows as much as is wanted is the last resort, whatever hides in it.
        put = [item for item in report.requests if item.means == kind]
        assert put
        assert {item.kind for item in put} <= {"load", "pallet"}
    else:
        assert {item.kind for item in report.requests} == {kind}


def single(scene: SceneSpec, config: OcclusionConfig, views: ViewpointsConfig) -> OcclusionReport:
    recipe = SceneRecipe(viewpoints=views)
    _, report = request_views(scene, recipe, CAMERA, config, RayCaster(scene), np.random.default_rng(0))
    return report


def test_a_high_target_is_too_high_for_what_stands_on_the_floor() -> None:
    draft = SceneDraft()
    on_floor(draft, "floor_slab", 0.0, 0.0, z=-0.2, loose=False)
    on_floor(draft, "epal1", 0.0, 0.0, z=4.0, loose=False)
    scene = replace(hall(), models=draft.models, instances=tuple(draft.instances))
    config = replace(CONFIG, kinds=("traffic", "load"), tries=20)
    views = ViewpointsConfig(height=Distribution.constant(4.0), distance=Distribution.uniform(2.5, 4.0))
    report = single(scene, config, views)
    (item,) = report.requests
    assert not item.met
    assert report.reasons == {"target too high for a floor occluder": 1}
    assert item.target == 2
    assert item.reached == 1.0
    assert report.success_rate == 0.0


def test_a_target_behind_a_wall_and_a_full_hall_are_reported() -> None:
    config, low = replace(CONFIG, tries=20), ViewpointsConfig(height=Distribution.constant(0.5))
    wall = [("drum_steel_216_black", x, -0.75) for x in np.arange(-3.0, 3.1, 0.57)]
    hidden = single(hall(*wall, loose=False), config, low)
    assert hidden.reasons == {"every target seen is hidden more than requested": 1}
    drums = [("drum_steel_216_black", x, y) for x in np.arange(-4.6, 4.7, 0.6) for y in np.arange(-4.6, -1.0, 0.6)]
    full = hall(*drums, loose=False)
    away = Viewpoint(level_camera(np.array([0.0, -4.5, 2.0]), -np.pi / 2))
    nowhere = single(replace(full, viewpoints=(away,)), config, low)
    assert nowhere.reasons == {"no free place to look from": 1}
    assert nowhere.requests[0].target == 0


def test_views_of_a_drive_stay_where_they_are() -> None:
    scene = hall()
    drive = replace(scene, viewpoints=tuple(replace(item, sequence=0) for item in scene.viewpoints))
    config = replace(CONFIG, visible_fraction=VisibleFractions((FractionRange(0.3, 0.7),)))
    recipe = SceneRecipe(viewpoints=ViewpointsConfig())
    after, report = request_views(drive, recipe, CAMERA, config, RayCaster(drive), np.random.default_rng(1))
    assert report.success_rate == 1.0
    assert report.requests[0].means not in ("view", "border")
    np.testing.assert_array_equal(after.viewpoints[0].T_world_camera, scene.viewpoints[0].T_world_camera)


def test_vehicles_keep_their_room() -> None:
    recipe = smoke(4)
    views = replace(recipe.scene.viewpoints, kind="forklift_mast", distance=Distribution.uniform(2.5, 5.0), height=None)
    recipe = replace(recipe, scene=replace(recipe.scene, viewpoints=views))
    before, scene, report = requested(recipe, replace(CONFIG, kinds=("load", "pallet", "traffic", "border")))
    assert report.success_rate >= 0.75
    new = [box for item in scene.instances[len(before.instances) :] for box in _boxes(scene, item.instance_id)]
    for viewpoint in scene.viewpoints:
        bodies = vehicle_boxes(viewpoint)
        assert bodies
        assert all(BoxStack.of(bodies).clear_of(box, 0.05) for box in new)


def test_a_scene_without_an_aisle_is_rejected() -> None:
    scene = replace(hall(), aisle=None)
    with pytest.raises(PlacementError, match="does not say where its aisle is"):
        single(scene, CONFIG, ViewpointsConfig())
