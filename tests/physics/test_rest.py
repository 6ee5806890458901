"""Which objects settle together; open totes are hollow: goods lie in them, and they stand on each other as before."""

from dataclasses import replace

import numpy as np
import pytest

from tests.catalog.covering import bare_distances
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.loads.totes import TOTES, tote
from warehouse_sim.catalog.materials import materials
from warehouse_sim.catalog.parts import box_part, solid_box
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, invert, make_transform, transform_points
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.physics import SettleConfig, SettleReport, contact_state, settle_scene
from warehouse_sim.physics.build import to_mjspec
from warehouse_sim.physics.crush import crush_state
from warehouse_sim.physics.impulses import ImpulseConfig
from warehouse_sim.physics.rest import Rest, RestLimits, bring_to_rest, find_stacks
from warehouse_sim.physics.weights import weights_of
from warehouse_sim.scene import Distribution, SceneRecipe, sample_scene
from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig
from warehouse_sim.scene.loads.staging import StagingConfig
from warehouse_sim.scene.packing.load_config import UnitLoadConfig
from warehouse_sim.scene.packing.stacking import StackingConfig
from warehouse_sim.scene.solids import Solids
from warehouse_sim.schema import ObjectInstance, ObjectModel, SceneSpec

CARTON = "carton_600x400x400"


def stacks_of(*placed: tuple[str, float, float, int]) -> list[list[int]]:
    """Return instance ids by stack of loose objects given as (name, x, z of the underside, group)."""
    items = []
    for index, (name, x, z, group) in enumerate(placed):
        centre = np.array([x, 0.0, z + catalog_object(name).size[2] / 2])
        items.append(ObjectInstance(index + 1, name, make_transform(translation=centre), dynamic=True, group=group))
    models = {item.model: catalog_object(item.model) for item in items}
    return [[item.instance_id for item in stack] for stack in find_stacks(items, Solids.of(items, models))]


def test_the_pieces_of_a_load_settle_together_and_neighbours_apart() -> None:
    assert stacks_of(("epal1", 0.0, 0.0, 1), (CARTON, 0.0, 0.145, 1), ("epal1", 1.21, 0.0, 2)) == [[1, 2], [3]]


def test_loads_on_each_other_are_one_stack() -> None:
    tower = (("epal1", 0.0, 0.0, 1), (CARTON, 0.0, 0.145, 1), ("epal1", 0.1, 0.555, 2), ("epal1", 0.1, 0.71, 3))
    assert stacks_of(*tower) == [[1, 2, 3, 4]]


def test_a_load_high_above_another_is_not_on_it() -> None:
    assert stacks_of(("epal1", 0.0, 0.0, 1), ("epal1", 0.0, 1.45, 2)) == [[1], [2]]


def test_the_lowest_stack_comes_first_and_things_without_a_group_are_loads_of_their_own() -> None:
    assert stacks_of(("epal1", 0.0, 2.0, 1), ("epal1", 3.0, 0.0, 0), ("epal1", 6.0, 0.0, 0)) == [[2], [3], [1]]


def test_nothing_loose_is_no_stack() -> None:
    assert find_stacks((), Solids.of((), {})) == []


FLOOR = OrientedBox(make_transform(translation=np.array([0.0, 0.0, -0.5])), np.array([20.0, 20.0, 1.0]))
LIMITS = RestLimits(speed=0.005, turn=0.02, time=4.0)
OPEN = [name for name in TOTES if "lid" not in name and name.endswith("grey")]
EDGE = 0.05
CUBE = ObjectModel(
    "cube",
    "carton",
    9999,
    np.full(3, EDGE),
    (box_part((EDGE,) * 3, (0, 0, 0), "kraft"),),
    (solid_box((EDGE,) * 3),),
    0.2,
)


def at(x: float, y: float, z: float) -> Transform:
    return make_transform(translation=np.array([x, y, z]))


def scene_of(*items: tuple[ObjectModel, Transform]) -> SceneSpec:
    models = {model.name: model for model, _ in items}
    things = tuple(
        ObjectInstance(number + 1, model.name, T, dynamic=True, group=1) for number, (model, T) in enumerate(items)
    )
    return SceneSpec(0, 0, models, materials(), things, (), ())


def settled(scene: SceneSpec) -> Rest:
    rest = bring_to_rest(scene, list(scene.instances), [FLOOR], LIMITS)
    assert rest.within(LIMITS)
    return rest


@pytest.mark.parametrize("name", OPEN)
def test_what_is_dropped_into_it_lies_below_its_rim(name: str) -> None:
    model = tote(name)
    top = model.size[2]
    rest = settled(scene_of((model, at(0, 0, top / 2)), (CUBE, at(0.0, 0.02, top + 0.12))))
    in_tote = transform_points(np.linalg.inv(rest.poses[1]), rest.poses[2][:3, 3][None])[0]
    assert (np.abs(in_tote[:2]) < model.size[:2] / 2 - 0.017 - 0.4 * EDGE).all()
    assert in_tote[2] < model.size[2] / 2, "with a closed box it lay half its edge above the rim"


def test_the_same_lies_on_top_of_a_lid() -> None:
    model = tote("tote_600x400x280_lid_grey")
    rest = settled(scene_of((model, at(0, 0, 0.14)), (CUBE, at(0.0, 0.02, 0.36))))
    assert rest.poses[2][2, 3] == pytest.approx(0.28 + EDGE / 2, abs=0.002)


@pytest.mark.parametrize("name", OPEN)
def test_a_stack_stands_where_it_was_put(name: str) -> None:
    model = tote(name)
    height = model.size[2]
    scene = scene_of(*((model, at(0.002 * level, 0, (level + 0.5) * height)) for level in range(4)))
    rest = settled(scene)
    for item in scene.instances:
        assert np.abs(rest.poses[item.instance_id] - item.T_world_object).max() < 0.002


def test_in_a_bond_each_stands_on_the_rims_of_several() -> None:
    """Two below lengthwise, and two across on them: nothing falls in."""
    model = tote("tote_600x400x280_grey")
    across = make_transform(np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]), np.array([-0.2, 0.0, 0.42]))
    beside = make_transform(across[:3, :3], np.array([0.2, 0.0, 0.42]))
    below = [(model, at(0, y, 0.14)) for y in (-0.2, 0.2)]
    rest = settled(scene_of(*below, (model, across), (model, beside)))
    for number in (3, 4):
        assert rest.poses[number][2, 3] == pytest.approx(0.42, abs=0.002)


@pytest.mark.parametrize("name", OPEN)
def test_masses_and_the_crush_rule_are_those_of_a_closed_one(name: str) -> None:
    model = tote(name)
    closed = replace(model, collision=(solid_box(model.size.tolist()),))
    stacks = [
        scene_of(*((one, at(0, 0, (level + 0.5) * one.size[2])) for level in range(3))) for one in (model, closed)
    ]
    compiled = to_mjspec(stacks[0]).compile()
    assert compiled.body_mass[1:] == pytest.approx([model.mass] * 3)
    mine, theirs = (weights_of(scene) for scene in stacks)
    assert mine.carried == pytest.approx(theirs.carried)
    assert mine.carried == pytest.approx({1: 2 * model.mass, 2: model.mass, 3: 0.0})
    assert crush_state(stacks[0]).to_plain() == crush_state(stacks[1]).to_plain()


@pytest.mark.parametrize("name", OPEN)
def test_boxes_lie_within_the_tote_and_cover_what_is_drawn_of_it(name: str) -> None:
    model = tote(name)
    corners = np.concatenate([box.corners() for box in model.collision])
    np.testing.assert_allclose(corners.max(axis=0), model.size / 2, atol=1e-12)
    np.testing.assert_allclose(corners.min(axis=0), -model.size / 2, atol=1e-12)
    assert bare_distances(model).max() < 0.006
    boxes = BoxStack.of(model.collision)
    over_goods = np.array([0.0, 0.0, model.size[2] / 2 - 0.004])
    local = np.einsum("nij,nj->ni", boxes.rotation.transpose(0, 2, 1), over_goods - boxes.centre)
    assert not (np.abs(local) <= boxes.half).all(axis=1).any()


HARD = ImpulseConfig(fraction=1.0, speed=Distribution.uniform(1.5, 2.5), pieces=Distribution.uniform(2, 6))


def recipe(**loads: float) -> SceneRecipe:
    stacking = StackingConfig(top_layer_fraction=Distribution.constant(1.0))
    return SceneRecipe(
        layout=RackAisleConfig(bays=1, beam_levels=(1.45,)),
        staging=StagingConfig(count=Distribution.constant(3)),
        loads=UnitLoadConfig(empty_fraction=0.0, stacking=stacking, **loads),  # type: ignore[arg-type]
        observations_per_scene=1,
    )


@pytest.fixture(scope="module")
def struck() -> list[tuple[SceneSpec, SceneSpec, SettleReport]]:
    scenes = [sample_scene(recipe(), 3, index) for index in range(2)]
    return [
        (settle_scene(scene, SettleConfig())[0], *settle_scene(scene, SettleConfig(impulses=HARD))) for scene in scenes
    ]


def test_goods_are_shifted_and_fall_and_the_scene_still_stands(struck) -> None:
    for _, scene, report in struck:
        assert report.problems == ()
        assert report.struck
        state = contact_state(scene)
        assert state.max_overlap < 0.001
        assert state.max_gap < 0.001
        assert state.lowest > -0.001
    assert sum(len(report.fallen) for _, _, report in struck) >= 3
    assert sum(len(report.shifted) for _, _, report in struck) >= 3


def test_only_the_loads_that_the_report_names_are_disturbed(struck) -> None:
    for at_rest, scene, report in struck:
        for before, after in zip(at_rest.instances, scene.instances, strict=True):
            way = np.linalg.norm((invert(before.T_world_object) @ after.T_world_object)[:3, 3])
            if after.group not in report.struck:
                assert way == 0.0
            elif after.instance_id in report.fallen:
                assert way > 0.05


def test_impulses_repeat_with_the_scene(struck) -> None:
    _, first, report = struck[0]
    again, repeated = settle_scene(sample_scene(recipe(), 3, 0), SettleConfig(impulses=HARD))
    assert repeated == report
    for a, b in zip(first.instances, again.instances, strict=True):
        assert a.T_world_object.tobytes() == b.T_world_object.tobytes()


def test_wrapped_loads_are_left_alone_and_their_film_follows_the_pallet() -> None:
    scene = sample_scene(recipe(wrap_fraction=1.0), 0, 0)
    settled, report = settle_scene(scene, SettleConfig(impulses=HARD))
    assert report.struck == ()
    films = [item for item in settled.instances if settled.model_of(item).class_name == "wrap"]
    assert films
    for film in films:
        pallet = next(item for item in settled.instances if item.group == film.group and item.dynamic)
        before = {item.instance_id: item.T_world_object for item in scene.instances}
        T_pallet_film = invert(pallet.T_world_object) @ film.T_world_object
        np.testing.assert_allclose(
            T_pallet_film, invert(before[pallet.instance_id]) @ before[film.instance_id], atol=1e-9
        )
