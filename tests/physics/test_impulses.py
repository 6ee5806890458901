import numpy as np
import pytest

from warehouse_sim.geometry.pose import invert
from warehouse_sim.physics import SettleConfig, SettleReport, contact_state, settle_scene
from warehouse_sim.physics.impulses import ImpulseConfig
from warehouse_sim.scene import Distribution, SceneRecipe, sample_scene
from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig
from warehouse_sim.scene.loads.staging import StagingConfig
from warehouse_sim.scene.packing.load_config import UnitLoadConfig
from warehouse_sim.scene.packing.stacking import StackingConfig
from warehouse_sim.schema import SceneSpec

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
