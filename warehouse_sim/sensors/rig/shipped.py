"""Rigs that come with the package, one YAML file each."""

from pathlib import Path
from typing import Any

from warehouse_sim.errors import ConfigError, UnknownNameError
from warehouse_sim.resources import data_folder
from warehouse_sim.yaml_file import read_yaml


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
