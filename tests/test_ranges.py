"""Ranges: which numbers they hold, and that a settings class keeps to them wherever its values come from."""

import math
from dataclasses import dataclass, replace
from typing import Annotated, Literal

import pytest

from warehouse_sim.config import from_mapping
from warehouse_sim.errors import ConfigError
from warehouse_sim.ranges import Fraction, Range, ranged


@dataclass(frozen=True)
@ranged
class Light:
    height: Annotated[float, Range(0.1, 10, "m")] = 2.0
    fractions: Annotated[tuple[float, ...], Range(0, 1)] = ()
    spot: Fraction | None = None

    def __post_init__(self) -> None:
        if self.spot == self.height:
            raise ValueError("spot and height must differ")


@dataclass(frozen=True)
@ranged
class HighLight(Light):
    count: Annotated[int, Range(1, 1000)] = 1


@pytest.mark.parametrize("height", [0.1, 10, 3.7])
def test_both_ends_belong_to_a_range(height: float) -> None:
    assert Light(height).height == height


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"height": math.nan}, "height must be 0.1-10 m, found nan"),
        ({"height": math.inf}, "height must be 0.1-10 m, found inf"),
        ({"height": 1e9}, "height must be 0.1-10 m, found 1000000000.0"),
        ({"fractions": (0.5, math.nan)}, "fractions[1] must be 0-1, found nan"),
        ({"spot": -0.1}, "spot must be 0-1, found -0.1"),
        ({"spot": 1.0, "height": 1.0}, "spot and height must differ"),
        ({"count": 0}, "count must be 1-1,000, found 0"),
    ],
)
def test_a_number_outside_is_rejected_from_everywhere(values: dict, message: str) -> None:
    for make in (lambda: HighLight(**values), lambda: replace(HighLight(), **values)):
        with pytest.raises(ConfigError) as caught:
            make()
        assert str(caught.value) == message
    with pytest.raises(ConfigError) as caught:
        from_mapping(HighLight, {key: list(v) if isinstance(v, tuple) else v for key, v in values.items()}, "a.yaml")
    assert str(caught.value) == f"a.yaml: {message}"


def test_a_range_is_written_without_exponents() -> None:
    assert [str(item) for item in (Range(0, 200_000), Range(-0.5, 2.5), Range(0.000001, 1))] == [
        "0-200,000",
        "-0.5 to 2.5",
        "0.000001-1",
    ]


@dataclass(frozen=True)
@ranged
class Lamp:
    kind: Literal["point", "area"] = "point"
    beam: Literal["narrow", "wide"] | Annotated[float, Range(1, 90, "deg")] | None = None
    colour: Literal["warm"] | str = "warm"


def test_a_name_that_is_not_listed_is_rejected_at_once() -> None:
    with pytest.raises(ConfigError) as caught:
        Lamp(kind="arae")  # type: ignore[arg-type]
    assert str(caught.value) == "kind must be one of 'point', 'area', found 'arae' (did you mean 'area'?)"
    with pytest.raises(ConfigError, match="beam must be one of 'narrow', 'wide', found 'broad'"):
        replace(Lamp(), beam="broad")


def test_listed_names_numbers_and_any_other_text_are_taken() -> None:
    assert Lamp("area", "wide", "blue").colour == "blue"
    assert Lamp(beam=30.0).beam == 30.0
    assert Lamp().beam is None
