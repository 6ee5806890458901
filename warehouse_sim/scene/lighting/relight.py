"""Another light for luminaires that hang already."""

from collections.abc import Mapping
from typing import Any

from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import ConfigError
from warehouse_sim.scene.lighting.config import LightingConfig

HANGING = ("rows", "luminaires", "mounting_height", "luminaire")
"""Settings that say where luminaires hang: geometry of the scene."""
_OF_THE_HALL = (*HANGING, "hall_fraction", "daylight")


def relit(config: LightingConfig, preset: str, settings: Mapping[str, Any], where: str) -> LightingConfig:
    """Return the light of a preset in a hall; nothing but its luminaires is kept of what was said of light before.

    Args:
        config: The light of the scene.
        preset: Name of the preset.
        settings: Any others of ``LightingConfig``.
        where: What takes them, for messages.

    Raises:
        ConfigError: A setting does not exist, does not fit, or moves luminaires.
    """
    if moved := [key for key in HANGING if key in settings]:
        raise ConfigError(
            f"{where}: {', '.join(moved)}: luminaires hang already; say it in a recipe, under scene.lights"
        )
    kept = {key: to_mapping(getattr(config, key)) for key in _OF_THE_HALL}
    return from_mapping(LightingConfig, kept | {"preset": preset} | dict(settings), where)
