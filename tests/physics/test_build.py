import mujoco
import numpy as np

from warehouse_sim.geometry.pose import matrix_from_quat_wxyz
from warehouse_sim.physics import to_mjspec
from warehouse_sim.scene import SceneRecipe, sample_scene
from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig

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
