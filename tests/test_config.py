from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import pytest

from warehouse_sim.config import from_mapping, load_yaml, to_mapping
from warehouse_sim.errors import ConfigError, RecipeError


@dataclass(frozen=True)
class Lens:
    width: int = 4
    kind: Literal["wide", "tele"] = "wide"


@dataclass(frozen=True)
class Rig:
    name: str
    lens: Lens = field(default_factory=Lens)
    heights: tuple[float, ...] = ()
    offset: tuple[float, float] | None = None


def test_nested_values_are_read_and_written_back() -> None:
    data = {"name": "a", "lens": {"width": 7, "kind": "tele"}, "heights": [1, 2.5], "offset": [0, 1]}
    rig = from_mapping(Rig, data, "rig.yaml")
    assert rig == Rig("a", Lens(7, "tele"), (1.0, 2.5), (0.0, 1.0))
    assert from_mapping(Rig, to_mapping(rig), "again") == rig


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ({"name": "a", "lens": {"widht": 3}}, "rig.yaml: lens: widht is not a setting; did you mean 'width'?"),
        ({}, "rig.yaml: the setting 'name' is missing"),
        ({"name": 3}, "rig.yaml: name must be str, found 3"),
        ({"name": "a", "lens": {"width": 2.5}}, "rig.yaml: lens: width must be int, found 2.5"),
        ({"name": "a", "lens": {"kind": "fish"}}, "rig.yaml: lens: kind must be one of 'wide', 'tele', found 'fish'"),
        ({"name": "a", "heights": [1, "x"]}, "rig.yaml: heights[1] must be float, found 'x'"),
        ({"name": "a", "offset": [1]}, "rig.yaml: offset must have 2 values, found 1"),
        ([1], "rig.yaml: expected a mapping of settings, found [1]"),
    ],
)
def test_a_wrong_setting_is_one_clear_line(data, message) -> None:
    with pytest.raises(ConfigError) as caught:
        from_mapping(Rig, data, "rig.yaml")
    assert str(caught.value) == message


def test_files_that_cannot_be_read_raise_the_error_requested_for(tmp_path: Path) -> None:
    with pytest.raises(RecipeError, match="cannot be read"):
        load_yaml(Rig, tmp_path / "no.yaml", RecipeError)
    bad = tmp_path / "bad.yaml"
    bad.write_text("name: [unclosed")
    with pytest.raises(RecipeError, match="is not valid YAML"):
        load_yaml(Rig, bad, RecipeError)
