"""The rules that make hostile documents do what their names say."""

import json
import math

import pytest
import yaml

from benchmarks.acceptance.hostile.documents import leaves, mutated_document, mutated_leaf
from benchmarks.acceptance.hostile.quantities import expectation

RECIPE = {
    "description": "a hall",
    "scene": {"bays": 3, "empty_fraction": 0.25, "beam_levels": [1.45, 2.9], "roof": False, "lux": None},
    "yaw_deg": {"min": -4.0, "max": 4.0},
}


def mutants(path: tuple, language: str = "yaml") -> dict:
    return {mutant.mutation: mutant for mutant in mutated_leaf(RECIPE, path, language)}


def test_every_leaf_is_found() -> None:
    found = dict(leaves(RECIPE))
    assert len(found) == 9
    assert found["scene", "beam_levels", 1] == 2.9


@pytest.mark.parametrize("language", ["yaml", "json"])
def test_numbers_arrive_as_they_are_named(language: str) -> None:
    made = mutants(("scene", "bays"), language)
    read = yaml.safe_load if language == "yaml" else json.loads
    values = {
        name: read(made[name].make())["scene"]["bays"]
        for name in made
        if name not in ("digits_5001", "misspelt", "deleted")
    }
    assert math.isnan(values["nan"])
    assert values["inf"] == math.inf
    assert values["minus_inf"] == -math.inf
    assert (values["negative"], values["zero"], values["fraction"], values["e9"]) == (-3, 0, 3.5, 10**9)
    assert values["huge_integer"] == int("9" * 30)
    assert (values["string"], values["list"], values["mapping"], values["null"]) == ("seven", [1, 2], {"a": 1}, None)
    assert b"9" * 5001 in made["digits_5001"].make()


def test_keys_are_deleted_misspelt_and_given_twice() -> None:
    made = mutants(("scene", "bays"))
    assert "bays" not in yaml.safe_load(made["deleted"].make())["scene"]
    assert set(yaml.safe_load(made["misspelt"].make())["scene"]) == {*RECIPE["scene"], "bay"} - {"bays"}
    assert made["duplicated"].make().count(b"bays: 3") == 2


def test_nothing_but_the_leaf_changes() -> None:
    for path, before in leaves(RECIPE):
        for name, mutant in mutants(path).items():
            if name in ("digits_5001", "deleted", "misspelt", "duplicated"):
                continue
            changed = dict(leaves(yaml.safe_load(mutant.make())))
            others = {other: value for other, value in leaves(RECIPE) if other != path}
            assert {other: changed[other] for other in others} == others, (path, name)
            if path in changed:
                assert changed[path] is not before or name == "nan"


def test_no_mutant_means_what_was_there() -> None:
    assert "zero" not in {mutant.mutation for mutant in mutated_leaf({"count": 0}, ("count",), "yaml")}
    assert "null" not in mutants(("scene", "lux"))
    assert "negative" in mutants(("yaw_deg", "max"))


@pytest.mark.parametrize(
    ("path", "value", "mutation", "must"),
    [
        (("scene", "lux"), None, "nan", "reject"),
        (("scene", "staging", "count"), 1, "fraction", "reject"),
        (("scene", "viewpoints", "height", "min"), 0.4, "negative", "reject"),
        (("sensors", "lidar", "max_range"), 100.0, "e9", "reject"),
        (("scene", "lanes", "yaw_deg", "max"), 4.0, "negative", "either"),
        (("sensors", "lidar_position", 0), -0.27, "negative", "either"),
        (("scene", "loads", "empty_fraction"), 0.25, "above_one", "reject"),
        (("scene", "lights", "hall_fraction"), 0.5, "above_one", "either"),
        (("scene", "loads", "empty_fraction"), 0.25, "zero", "either"),
        (("sensors", "camera", "focal_px"), 160.0, "zero", "reject"),
        (("description",), "a hall", "empty", "either"),
        (("scene", "layout", "kind"), "rack_aisle", "string", "reject"),
        (("scene", "hall", "roof"), False, "string", "reject"),
        (("seed",), 0, "e9", "either"),
        (("scene", "bays"), 3, "duplicated", "reject"),
    ],
)
def test_what_nobody_can_mean(path: tuple, value: object, mutation: str, must: str) -> None:
    assert expectation(path, value, mutation) == must


def test_whole_documents() -> None:
    content = yaml.safe_dump(RECIPE).encode()
    whole = {mutant.mutation: mutant for mutant in mutated_document(content, "yaml")}
    for mutant in whole.values():
        if mutant.expect == "accept":
            assert yaml.safe_load(mutant.make()) == RECIPE, mutant.mutation
    assert len(whole["nested 3,000 deep"].make()) == 6000
    with pytest.raises(UnicodeDecodeError):
        whole["a byte that is no UTF-8"].make().decode()
