from warehouse_sim.catalog import shipped_classes
from warehouse_sim.catalog.building.outdoors import OUTDOORS
from warehouse_sim.render.coarse_scene import JOINED_GOODS
from warehouse_sim.schema.classes import CLASS_NUMBERS, class_number, is_stuff, kind_of, numbered

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
