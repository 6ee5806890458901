"""What differs between two scenes is told field by field, and by what they hold."""

from dataclasses import replace

import numpy as np
import pytest

from tests.dataset.toy import T_CAMERA_LIDAR, make_scene, observe
from warehouse_sim.catalog import shipped_classes
from warehouse_sim.catalog.building.outdoors import OUTDOORS
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.render.coarse_scene import JOINED_GOODS
from warehouse_sim.schema import LidarScan, Material, RgbdReading, SceneChange, SceneSpec
from warehouse_sim.schema.classes import CLASS_NUMBERS, class_number, is_stuff, kind_of, numbered

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


BUILT_IN_SCENES = {JOINED_GOODS, "service", "window", OUTDOORS}
"""Classes of what scenes make to measure."""
FOUND_ONLY = {"pallet_face"}
"""What networks find of an object, which is no object."""


def test_every_class_of_the_package_has_a_number_and_a_kind() -> None:
    assert set(CLASS_NUMBERS) == shipped_classes() | BUILT_IN_SCENES | FOUND_ONLY
    assert {kind_of(name) for name in CLASS_NUMBERS} == {"load", "pallet", "rack", "traffic", "building"}
    assert (kind_of("goods"), kind_of("window"), kind_of("robot")) == ("load", "building", "other")
    assert {name for name in CLASS_NUMBERS if is_stuff(name)} == {"floor", "wall", "ceiling", "marking"}


def test_classes_keep_their_numbers() -> None:
    assert sorted(CLASS_NUMBERS.values()) == list(range(1, len(CLASS_NUMBERS) + 1))
    kept = {"pallet": 1, "carton": 2, "floor": 27, "fire_equipment": 38, "goods": 39, "outdoors": 42, "pallet_face": 43}
    assert {name: CLASS_NUMBERS[name] for name in kept} == kept


def test_numbers_of_other_classes_follow_from_their_names() -> None:
    # Published check value of CRC-32: "123456789" gives cbf43926.
    assert class_number("123456789") == 1000 + 0xCBF43926 % 2**30
    found = numbered(["floor", "zebra", "pallet", "Car", "carton", "Car"])
    assert list(found)[:3] == ["pallet", "carton", "floor"]
    assert list(found.values()) == sorted(found.values())
    assert found["Car"] == class_number("Car") > 1000


# An observation gives the readings of the usual sensors by kind, and those of any other by name.


def test_readings_are_found_by_kind() -> None:
    observation = observe(make_scene(0))[0]
    assert isinstance(observation.rgbd, RgbdReading)
    assert isinstance(observation.lidar, LidarScan)
    assert observation.T_camera_lidar is T_CAMERA_LIDAR
    assert observation.stereo is None
    assert observation.lidars == {}


@pytest.mark.parametrize("name", ["camera", "lidar"])
def test_a_sensor_stays_where_it_is_unless_told(name: str) -> None:
    observation = observe(make_scene(0))[0]
    again = observation.with_reading(name, observation.readings[name].reading)
    assert again.readings[name].T_camera_sensor is observation.readings[name].T_camera_sensor
