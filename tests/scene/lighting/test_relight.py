import pytest

from warehouse_sim.errors import ConfigError
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.lighting.config import LightingConfig
from warehouse_sim.scene.lighting.presets import PRESETS
from warehouse_sim.scene.lighting.switching import relit

BEFORE = LightingConfig(rows=2, luminaires=5, mounting_height=6.0, lux=Distribution.constant(500.0), temperature=None)


def test_what_was_said_of_light_is_forgotten_and_luminaires_stay() -> None:
    after = relit(BEFORE, "night", {}, "here")
    assert (after.rows, after.luminaires, after.mounting_height) == (2, 5, 6.0)
    assert after.lux is None
    assert after.resolved() == PRESETS["night"]


def test_settings_of_light_are_taken() -> None:
    after = relit(BEFORE, "dim", {"lux": 12.0, "headlights": True}, "here")
    assert after.lux == Distribution.constant(12.0)
    assert after.headlights is True


@pytest.mark.parametrize("settings", [{"rows": 1}, {"luminaires": 2}, {"mounting_height": 5.0}, {"luminaire": "round"}])
def test_luminaires_are_not_moved(settings: dict) -> None:
    with pytest.raises(ConfigError, match=r"here: .*hang already"):
        relit(BEFORE, "dim", settings, "here")
