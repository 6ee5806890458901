"""Rigs that come with the package, one YAML file each, and the choice among cameras of a recipe."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import ConfigError, UnknownNameError, shown
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.resources import data_folder
from warehouse_sim.sensors.rgbd import RgbdConfig
from warehouse_sim.yaml_file import read_yaml


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


def rig_names() -> list[str]:
    """Return the names of the shipped rigs, sorted."""
    return sorted(path.stem for path in _folder().glob("*.yaml"))


def rig_comments() -> dict[str, str]:
    """Return the first sentence of each shipped rig's comment, by name."""
    found = {}
    for name in rig_names():
        text = (_folder() / f"{name}.yaml").read_text(encoding="utf-8")
        lines = [line[1:].strip() for line in text.splitlines() if line.startswith("#")]
        found[name] = " ".join(lines).split(". ")[0].rstrip(".")
    return found


def rig_settings(name_or_path: Any, where: str) -> dict[str, Any]:
    """Return the settings of a rig given by shipped name ("kitti") or by the path of a YAML file.

    Raises:
        ConfigError: Neither, or the file is no mapping.
    """
    path = Path(str(name_or_path))
    if path.suffix not in (".yaml", ".yml"):
        if name_or_path not in rig_names():
            problem = UnknownNameError("rig (a shipped name or the path of a .yaml file)", str(path), rig_names())
            raise ConfigError(f"{where}: {problem}")
        path = _folder() / f"{name_or_path}.yaml"
    try:
        settings = read_yaml(path)
    except ConfigError as problem:
        raise ConfigError(f"{where}: {problem}") from problem
    if not isinstance(settings, dict) or "rig" in settings:
        raise ConfigError(f"{where}: {path}: a rig is a mapping of settings that names no other rig")
    return settings


def _folder() -> Path:
    return data_folder("scenes") / "rigs"
