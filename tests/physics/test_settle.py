import time
from dataclasses import replace

import mujoco
import numpy as np
import pytest
import yaml

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.materials import materials
from warehouse_sim.config import from_mapping
from warehouse_sim.errors import SettleError
from warehouse_sim.geometry.mesh import unit_box
from warehouse_sim.geometry.pose import (
    invert,
    make_transform,
    matrix_from_quat_wxyz,
    rotation_x,
    rotation_z,
    transform_points,
)
from warehouse_sim.physics import SettleConfig, SettleReport, settle_scene, to_mjspec
from warehouse_sim.resources import data_folder
from warehouse_sim.scene import Distribution, SceneRecipe, sample_scene
from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig
from warehouse_sim.scene.loads.shelving import ShelvingConfig
from warehouse_sim.scene.loads.staging import StagingConfig
from warehouse_sim.scene.packing.load_config import UnitLoadConfig
from warehouse_sim.schema import ObjectInstance, ObjectModel, SceneSpec


def shipped(name: str) -> SceneRecipe:
    return SceneRecipe.from_plain(plain(name)["scene"], name)


def plain(name: str) -> dict[str, dict[str, object]]:
    return yaml.safe_load((data_folder("scenes") / f"{name}.yaml").read_text())


@pytest.fixture(scope="module", params=[0, 1])
def settled(request: pytest.FixtureRequest) -> tuple[SceneSpec, SceneSpec, SettleReport]:
    scene = sample_scene(shipped("smoke"), 0, request.param)
    return scene, *settle_scene(scene, from_mapping(SettleConfig, plain("smoke")["settle"], "smoke"))


def test_a_shipped_scene_comes_to_rest_without_problems(settled: tuple[SceneSpec, SceneSpec, SettleReport]) -> None:
    before, after, report = settled
    report.require_ok()
    assert after.settled
    assert not before.settled
    assert 0.0 < report.duration < 2.0
    assert report.max_speed < 0.002
    assert 0.0004 < report.max_drift < 0.03  # loads start with 0.5 mm of air under each piece
    assert report.max_overlap < 0.001
    assert report.max_gap < 0.001
    assert report.toppled == ()


def test_only_loose_things_moved_and_nothing_else_changed(settled: tuple[SceneSpec, SceneSpec, SettleReport]) -> None:
    before, after, _ = settled
    for old, new in zip(before.instances, after.instances, strict=True):
        assert replace(old, T_world_object=new.T_world_object).model == new.model
        assert (old.instance_id, old.dynamic, old.group) == (new.instance_id, new.dynamic, new.group)
        same = bool(np.array_equal(old.T_world_object, new.T_world_object))
        assert same != old.dynamic
        R = new.T_world_object[:3, :3]
        np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)
    assert before.viewpoints is after.viewpoints


def boxes_of(model: ObjectModel) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return frame and size (m) of the boxes that are sampled; those that collide for what is sampled otherwise."""
    if all(part.mesh is unit_box() for part in model.parts):
        return [(part.T_object_part, part.scale) for part in model.parts]
    return [(box.T_parent_box, box.size) for box in model.collision]


class World:
    """All visible boxes of a scene: a second opinion that shares no code with the physics room."""

    def __init__(self, scene: SceneSpec) -> None:
        rows = [(i, i.T_world_object @ T, size) for i in scene.instances for T, size in boxes_of(scene.model_of(i))]
        self.owner = np.array([item.instance_id for item, _, _ in rows])
        self.T = np.array([T for _, T, _ in rows])
        self.half = np.array([scale for _, _, scale in rows]) / 2

    def depth(self, points: np.ndarray, me: int) -> float:
        """Return how deep (m) the deepest of world ``points`` is inside a box of another object."""
        centre = points.mean(axis=0)
        reach = np.linalg.norm(points - centre, axis=1).max() + np.linalg.norm(self.half, axis=1)
        near = (self.owner != me) & (np.linalg.norm(self.T[:, :3, 3] - centre, axis=1) < reach)
        local = np.einsum("nij,nmi->nmj", self.T[near, :3, :3], points[None] - self.T[near, None, :3, 3])
        return float((self.half[near, None] - np.abs(local)).min(axis=2).max(initial=0.0))


def surface_points(size: np.ndarray) -> np.ndarray:
    """Return a grid over the faces of a box, in its frame (m), finer than a beam is deep."""
    lines = [np.linspace(-0.5, 0.5, 2 + int(edge / 0.045)) * edge for edge in size]
    grid = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 3)
    return grid[np.any(np.isclose(np.abs(grid), size / 2), axis=1)]


def test_nothing_overlaps_floats_or_sinks(settled: tuple[SceneSpec, SceneSpec, SettleReport]) -> None:
    """Points on the visible surface of every loose object are outside all others; 2 mm lower, some are inside."""
    _, scene, _ = settled
    world = World(scene)
    for item in scene.instances:
        if not item.dynamic:
            continue
        deepest, lowered = 0.0, 0.0
        for part in scene.model_of(item).parts:
            points = transform_points(item.T_world_object @ part.T_object_part, surface_points(part.scale))
            deepest = max(deepest, world.depth(points, item.instance_id))
            lowered = max(lowered, world.depth(points - [0.0, 0.0, 0.002], item.instance_id))
        assert deepest < 0.001
        assert lowered > 0.0005


def test_the_same_scene_settles_to_the_same_bytes() -> None:
    scene = sample_scene(shipped("smoke"), 3, 0)
    first, second = (settle_scene(scene, SettleConfig()) for _ in range(2))
    for a, b in zip(first[0].instances, second[0].instances, strict=True):
        assert a.T_world_object.tobytes() == b.T_world_object.tobytes()
    assert first[1] == second[1]
    assert first[1].struck == ()  # impulses are given where settings say so


def scene_with(*placed: tuple[str, np.ndarray]) -> SceneSpec:
    floor = ObjectInstance(1, "floor_slab", make_transform(translation=np.array([0.0, 0.0, -0.1])))
    loose = [ObjectInstance(k + 2, name, T, dynamic=True, group=1) for k, (name, T) in enumerate(placed)]
    models = {item.model: catalog_object(item.model) for item in (floor, *loose)}
    return SceneSpec(4, 9, models, materials(), (floor, *loose), (), ())


def at(z: float, x: float = 0.0, rotation: np.ndarray | None = None) -> np.ndarray:
    return make_transform(rotation, np.array([x, 0.0, z]))


def test_a_dropped_pallet_lands_flat_on_the_floor() -> None:
    scene, report = settle_scene(scene_with(("epal1", at(0.092, rotation=rotation_z(0.4)))), SettleConfig())
    report.require_ok()
    T = scene.instances[1].T_world_object
    np.testing.assert_allclose(T[:3, 3], [0.0, 0.0, 0.072], atol=2e-4)
    np.testing.assert_allclose(T[:3, :3], rotation_z(0.4), atol=1e-3)
    assert report.max_drift == pytest.approx(0.02, abs=3e-4)


def test_a_tall_heavy_stack_sinks_in_by_less_than_a_millimetre() -> None:
    cartons = [("carton_400x300x200", at(0.144 + 0.1 + 0.0005 + k * 0.2005)) for k in range(10)]
    _, report = settle_scene(scene_with(("epal1", at(0.0725)), *cartons), SettleConfig())
    report.require_ok()
    assert 0.0 < report.max_overlap < 0.0005


def test_a_carton_over_the_edge_topples_and_is_named() -> None:
    over = scene_with(("epal1", at(0.0725)), ("carton_600x400x400", at(0.3450, x=0.75)))
    _, report = settle_scene(over, SettleConfig())
    assert report.toppled == (3,)
    assert any(problem.startswith("object 3 toppled by") for problem in report.problems)
    assert any(problem.startswith("object 3 moved by") for problem in report.problems)
    with pytest.raises(SettleError, match=r"^scene 4 of seed 9 .*object 3 toppled") as caught:
        report.require_ok()
    assert "\n" not in str(caught.value)


def test_out_of_time_is_a_problem() -> None:
    _, report = settle_scene(scene_with(("carton_600x400x400", at(5.0))), SettleConfig(max_time=0.2))
    assert any("still moving at 1.9" in problem or "still moving at 2.0" in problem for problem in report.problems)
    assert any("floats" in problem for problem in report.problems)


def test_a_tilted_carton_falls_on_its_face_and_a_scene_without_loose_things_is_at_rest() -> None:
    tilted = scene_with(("carton_600x400x400", at(0.25, rotation=rotation_x(0.2))))
    scene, report = settle_scene(tilted, SettleConfig(max_tilt_deg=20.0, max_drift_mm=200.0))
    report.require_ok()
    assert scene.instances[1].T_world_object[2, 3] == pytest.approx(0.2, abs=3e-4)
    assert report.max_tilt == pytest.approx(0.2, abs=2e-3)
    _, empty = settle_scene(scene_with(), SettleConfig())
    assert empty.problems == ()
    assert empty.duration == 0.0


def test_settling_a_settled_scene_moves_it_no_further() -> None:
    settled, _ = settle_scene(sample_scene(shipped("smoke"), 0, 0), SettleConfig())
    again, report = settle_scene(settled, SettleConfig())
    assert report.max_drift < 1e-4
    T = [
        (invert(a.T_world_object) @ b.T_world_object)[:3, 3]
        for a, b in zip(settled.instances, again.instances, strict=True)
    ]
    assert np.abs(T).max() < 1e-4


def test_all_stacks_together_stay_where_each_came_to_rest_alone() -> None:
    """Stacks settle one by one; simulated at once for 0.3 s, with nothing fixed but the building, none moves."""
    settled, _ = settle_scene(sample_scene(shipped("smoke"), 0, 1), SettleConfig())
    model = to_mjspec(settled).compile()
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=150)
    for item in settled.instances:
        if item.dynamic:
            place = data.joint(model.body(str(item.instance_id)).jntadr[0]).qpos[:3]
            np.testing.assert_allclose(place, item.T_world_object[:3, 3], atol=5e-4)


@pytest.mark.slow
def test_a_warehouse_of_200_loaded_pallets_and_3000_cartons_settles_in_15_cpu_seconds() -> None:
    recipe = SceneRecipe(
        layout=RackAisleConfig(bays=12, beam_levels=(1.45, 2.9, 4.35), sides="both"),
        shelving=ShelvingConfig(empty_slot_fraction=0.2),
        staging=StagingConfig(count=Distribution.constant(0)),
        loads=UnitLoadConfig(empty_fraction=0.0, height=Distribution.uniform(0.6, 1.1), max_cartons=32),
    )
    start = time.process_time()
    scene, report = settle_scene(sample_scene(recipe, 0, 0), SettleConfig())
    assert time.process_time() - start < 15.0
    report.require_ok()
    classes = [scene.model_of(item).class_name for item in scene.instances]
    assert classes.count("pallet") >= 200
    assert classes.count("carton") >= 3000


SCENE = sample_scene(SceneRecipe(layout=RackAisleConfig(bays=1, beam_levels=(1.45,))), 0, 0)
MODEL = to_mjspec(SCENE).compile()


def test_each_instance_is_a_body_at_its_pose_and_loose_ones_are_free() -> None:
    data = mujoco.MjData(MODEL)
    mujoco.mj_kinematics(MODEL, data)
    for item in SCENE.instances:
        body = MODEL.body(str(item.instance_id))
        state = data.body(str(item.instance_id))
        np.testing.assert_allclose(state.xpos, item.T_world_object[:3, 3], atol=1e-12)
        np.testing.assert_allclose(matrix_from_quat_wxyz(state.xquat), item.T_world_object[:3, :3], atol=1e-12)
        assert body.jntnum[0] == int(item.dynamic)
    assert MODEL.njnt == sum(item.dynamic for item in SCENE.instances)


def test_loose_bodies_have_the_mass_of_their_model() -> None:
    for item in SCENE.instances:
        if item.dynamic:
            np.testing.assert_allclose(MODEL.body(str(item.instance_id)).mass, SCENE.model_of(item).mass)


def test_geoms_are_the_collision_boxes() -> None:
    for item in SCENE.instances:
        for index, box in enumerate(SCENE.model_of(item).collision):
            np.testing.assert_allclose(MODEL.geom(f"{item.instance_id}:{index}").size, box.size / 2)
    assert MODEL.ngeom == sum(len(SCENE.model_of(item).collision) for item in SCENE.instances)


def test_a_part_of_a_scene_can_be_built_alone() -> None:
    some = [item for item in SCENE.instances if item.group == 1]
    assert to_mjspec(SCENE, some).compile().nbody == len(some) + 1
