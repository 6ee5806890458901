"""What differs between two scenes is told field by field, and by what they hold."""

from dataclasses import replace

import numpy as np

from tests.dataset.toy import make_scene
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.schema import Material, SceneChange, SceneSpec

PAINT = Material("paint", (0.5, 0.2, 0.1))
GLASS = Material("glass", (0.9, 0.9, 0.9), emission=1.0)
NOTHING = SceneChange(objects=False, surfaces=False, emission=False, lights=False, area=False)


def scene() -> SceneSpec:
    return replace(make_scene(0), materials={"paint": PAINT, "glass": GLASS})


def test_equal_copies_do_not_differ() -> None:
    before = scene()
    copy = replace(
        before,
        instances=tuple(replace(item, T_world_object=item.T_world_object.copy()) for item in before.instances),
        lights=tuple(replace(item, position=item.position.copy()) for item in before.lights),
        materials={name: replace(item) for name, item in before.materials.items()},
        models=dict(before.models),
    )
    change = SceneChange.between(before, copy)
    assert change == NOTHING
    assert change.nothing


def test_viewpoints_and_exposure_are_no_change() -> None:
    before = scene()
    assert SceneChange.between(before, replace(before, viewpoints=(), exposure=0.5)).nothing


def test_each_change_is_told_alone() -> None:
    before = scene()
    moved = replace(before.instances[1], T_world_object=make_transform(None, np.array([0.0, 0.0, 1.0])))
    after = replace(before, instances=(before.instances[0], moved, *before.instances[2:]))
    assert SceneChange.between(before, after) == replace(NOTHING, objects=True)

    brighter = replace(before, lights=tuple(replace(item, intensity=1.0) for item in before.lights))
    assert SceneChange.between(before, brighter) == replace(NOTHING, lights=True)
    assert SceneChange.between(before, replace(before, ambient=1.0)) == replace(NOTHING, lights=True)

    dark = replace(before, materials={"paint": PAINT, "glass": replace(GLASS, emission=0.0)})
    assert SceneChange.between(before, dark) == replace(NOTHING, emission=True)

    assert SceneChange.between(before, replace(before, targets=("carton",))) == replace(NOTHING, area=True)
    assert SceneChange.between(before, replace(before, aisle=(-1.0, 1.0, -1.0, 1.0))) == replace(NOTHING, area=True)

    other = replace(before, materials={"paint": replace(PAINT, roughness=0.1), "glass": GLASS})
    assert SceneChange.between(before, other).surfaces


def test_one_object_less_is_another_set() -> None:
    before = scene()
    assert SceneChange.between(before, replace(before, instances=before.instances[:-1])).objects


def test_another_paint_is_another_object() -> None:
    before = scene()
    painted = replace(before.instances[1], paint={"wood": "paint"})
    after = replace(before, instances=(before.instances[0], painted, *before.instances[2:]))
    assert SceneChange.between(before, after) == replace(NOTHING, objects=True)
    assert SceneChange.between(after, after).nothing
