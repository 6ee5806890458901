"""One of the cameras that a recipe draws from, a scene at a time."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np

from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import ConfigError, shown
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.sensors.rgbd import RgbdConfig


@dataclass(frozen=True)
@ranged
class SensorChoice:
    """Errors of an RGB-D camera under a name; in YAML also the name of a depth preset alone."""

    name: str
    """What observations, and scores by sensor, call it."""
    rgbd: RgbdConfig = field(default_factory=RgbdConfig)
    """Noise of colour and depth."""
    weight: Annotated[float, Range(1e-6, 1e6)] = 1.0
    """How often it is rendered, relative to the others, 0.000001-1,000,000."""

    @classmethod
    def from_plain(cls, data: Any, where: str) -> "SensorChoice":
        """Read a depth preset's name, or ``{name: ..., weight: ..., depth: ..., color: ...}``.

        Raises:
            ConfigError: No name, or an unknown setting.
        """
        if isinstance(data, str):
            return cls(data, from_mapping(RgbdConfig, {"depth": data}, where))
        if not isinstance(data, dict) or not isinstance(data.get("name"), str) or not data["name"]:
            wanted = "a depth preset's name, or {name: ..., depth: ..., color: ...}"
            raise ConfigError(f"{where}: expected {wanted}; found {shown(data)}")
        rgbd = {key: value for key, value in data.items() if key not in ("name", "weight")}
        own = {key: data[key] for key in ("name", "weight") if key in data}
        return from_mapping(cls, own | {"rgbd": rgbd}, where)

    def to_plain(self) -> dict[str, Any]:
        """Return what ``from_plain`` reads back."""
        return {"name": self.name, "weight": self.weight, **to_mapping(self.rgbd)}


def rendered_choice(choices: Sequence[SensorChoice], rng: np.random.Generator) -> SensorChoice:
    """Return one of several, at least one, by their weights."""
    weights = np.array([choice.weight for choice in choices])
    return choices[int(rng.choice(len(choices), p=weights / weights.sum()))]
