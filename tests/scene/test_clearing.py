import logging

import numpy as np
import pytest

from warehouse_sim.errors import PlacementError
from warehouse_sim.physics.check import contact_state
from warehouse_sim.scene.hand_made import cleared, empty_scene, is_loose, with_object, with_replaced
from warehouse_sim.schema import SceneSpec


def scene_of(*objects: tuple[str, float, float]) -> SceneSpec:
    scene = empty_scene(0)
    for name, x, y in objects:
        scene = with_object(scene, name, x, y, None, 0.0)
    return scene


def shift(before: SceneSpec, after: SceneSpec, number: int) -> np.ndarray:
    return after.instances[number].T_world_object[:3, 3] - before.instances[number].T_world_object[:3, 3]


def test_what_is_clear_stays() -> None:
    scene = scene_of(("epal1", 0.0, 0.0), ("epal1", 1.3, 0.0), ("carton_600x400x300", 0.0, 0.0))
    assert cleared(scene).instances == scene.instances


def test_the_later_load_gives_way_by_the_shortest_way_with_all_that_stands_on_it(
    caplog: pytest.LogCaptureFixture,
) -> None:
    scene = scene_of(("epal1", 0.0, 0.0))
    scene = with_object(scene, "epal1", 1.1, 0.0, 0.0725, 0.0)
    scene = with_object(scene, "carton_600x400x300", 1.1, 0.0, None, 0.0)
    with caplog.at_level(logging.WARNING):
        after = cleared(scene)
    np.testing.assert_array_equal(shift(scene, after, -3), np.zeros(3))
    np.testing.assert_allclose(shift(scene, after, -2), [0.1, 0.0, 0.0], atol=0.021)
    np.testing.assert_array_equal(shift(scene, after, -1), shift(scene, after, -2))
    assert contact_state(after).problems(2.1, 1.0) == []
    assert "epal1 (object" in caplog.text
    assert caplog.text.count("was moved") == 1


def test_what_has_no_free_place_is_an_error() -> None:
    in_the_floor = with_object(empty_scene(0), "epal1", 0.0, 0.0, 0.02, 0.0)
    with pytest.raises(PlacementError, match=r"epal1 .* overlaps .* put it elsewhere"):
        cleared(in_the_floor)


def test_what_replaces_stands_on_the_same_ground() -> None:
    scene = scene_of(("epal1", 0.0, 0.0), ("carton_600x400x300", 0.0, 0.0))
    after, count = with_replaced(scene, "carton_600x400x300", "carton_400x300x200")
    assert count == 1
    np.testing.assert_allclose(shift(scene, after, -1), [0.0, 0.0, -0.05], atol=1e-12)
    assert "carton_600x400x300" not in after.models
    assert after.instances[-1].group == scene.instances[-2].group


@pytest.mark.parametrize(
    ("name", "loose"),
    [("epal1", True), ("carton_600x400x300", True), ("shelf_bay", False), ("forklift", False), ("cone_500", True),
     ("person_tall_standing", False), ("wall", False)],
)  # fmt: skip
def test_what_people_set_down_is_loose(name: str, loose: bool) -> None:
    scene = scene_of((name, 0.0, 0.0))
    assert is_loose(scene.model_of(scene.instances[-1])) is loose
    assert scene.instances[-1].dynamic is loose
