from pathlib import Path

import numpy as np
import pytest

from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import ConfigError
from warehouse_sim.scene import Distribution
from warehouse_sim.scene.packing.load_config import UnitLoadConfig, WearRange


def test_settings_survive_a_round_trip_through_plain_data() -> None:
    config = UnitLoadConfig(
        patterns=("interlock", "column"),
        damaged_fraction=0.5,
        wear=WearRange(age=Distribution.constant(0.3)),
        wrap_fraction=0.2,
    )
    assert from_mapping(UnitLoadConfig, to_mapping(config), "loads") == config


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"wrap_fraction": 1.2}, "wrap_fraction must be 0-1"),
        ({"tote_fraction": 0.7, "sack_fraction": 0.7}, "must not exceed 1 together"),
        ({"max_cartons": 0}, "max_cartons must be 1-1,000, found 0"),
        ({"patterns": []}, "at least one pattern"),
        ({"patterns": ["herringbone"]}, "herringbone"),
        ({"drums": ["epal1"]}, "drums must list catalog objects of class drum"),
        ({"sacks": ["sack"]}, "sacks"),
        ({"wear": {"age": 2}}, "age must stay within 0-1"),
    ],
)
def test_what_cannot_be_is_rejected(settings: dict, message: str) -> None:
    with pytest.raises((ConfigError, ValueError), match=message):
        from_mapping(UnitLoadConfig, settings, str(Path("recipe.yaml: loads")))


def test_wear_is_drawn_from_its_ranges() -> None:
    wear = WearRange(broken=Distribution.constant(0.25)).sampled(np.random.default_rng(0))
    assert wear.broken == 0.25
    assert 0.1 <= wear.age <= 1.0
