"""``extends`` of a recipe file: another recipe, with some of its settings replaced."""

import os
from pathlib import Path
from typing import Any

from warehouse_sim.errors import RecipeError, UnknownNameError, shown
from warehouse_sim.resources import find_recipe
from warehouse_sim.yaml_file import read_yaml

KEY = "extends"
# A mapping of such keys is one value, an open number or name: half of one and half of another would be neither.
_DISTRIBUTION = frozenset({"min", "max", "mean", "std", "choices", "weights"})
# Where a setting says what kind of thing a mapping describes: settings of one kind do not suit another.
_KINDS = {
    "layout": ("kind",),
    "front": ("kind",),
    "back": ("kind",),
    "lidar": ("model",),
    "depth": ("preset", "model"),
    "sensors": ("rig",),
}
# What a preset decides where the recipe is silent: naming a preset drops what the extended recipe says of it.
_OF_PRESET = {
    "lights": frozenset(
        [
            "lux",
            "flux",
            "beam_deg",
            "photometry",
            "photometry_flux",
            "temperature",
            "ambient_fraction",
            "headlights",
            "white_balance",
            "exposure",
            "compensation",
        ]
    ),
}


def read_chain(path: Path) -> list[tuple[Path, dict[str, Any]]]:
    """Return a recipe file and all that it extends, the innermost first, each with its own settings.

    Raises:
        RecipeError: A file cannot be read, is no mapping, names no recipe under ``extends``, or extends itself.
    """
    chain: list[tuple[Path, dict[str, Any]]] = []
    following: Path | None = path
    while following is not None:
        if os.path.realpath(following) in [os.path.realpath(seen) for seen, _ in chain]:
            way = " -> ".join(str(seen) for seen in [*(seen for seen, _ in chain), following])
            raise RecipeError(f"{chain[-1][0]}: {KEY} leads back to where it began: {way}")
        settings = read_yaml(following, RecipeError) or {}
        if not isinstance(settings, dict):
            raise RecipeError(f"{following}: expected a mapping of settings, found {shown(settings)}")
        chain.append((following, {key: value for key, value in settings.items() if key != KEY}))
        following = _extended(settings[KEY], following) if KEY in settings else None
    return chain[::-1]


def overlay(base: dict[str, Any], settings: dict[str, Any]) -> dict[str, Any]:
    """Return ``base`` with ``settings`` in place of its own; mappings are merged key by key, at any depth.

    Lists and distributions are replaced as a whole, and so is a mapping of another kind: another layout, another
    model of LiDAR or depth, another rig. ``lights`` that name a preset keep only where luminaires hang.
    """
    merged = dict(base)
    for key, value in settings.items():
        own = base.get(key)
        if isinstance(own, dict) and isinstance(value, dict) and "preset" in value:
            own = {name: item for name, item in own.items() if name not in _OF_PRESET.get(key, ())}
        merged[key] = overlay(own, value) if _can_merge(key, own, value) else value  # type: ignore[arg-type]
    return merged


def _extended(value: Any, path: Path) -> Path:
    """Return the file that ``extends: value`` in the file ``path`` means; a path is seen from that file's folder."""
    if not isinstance(value, str):
        raise RecipeError(
            f"{path}: {KEY} must be a shipped recipe's name or the path of a .yaml file, found {shown(value)}"
        )
    try:
        beside = Path(value).suffix in (".yaml", ".yml")
        return find_recipe(str(path.parent / value) if beside else value)
    except UnknownNameError as problem:
        raise RecipeError(f"{path}: {KEY}: {problem}") from problem


def _can_merge(key: str, own: Any, value: Any) -> bool:
    if not (isinstance(own, dict) and isinstance(value, dict)):
        return False
    of_another_kind = any(name in value and value[name] != own.get(name) for name in _KINDS.get(key, ()))
    return not (of_another_kind or _is_distribution(own) or _is_distribution(value))


def _is_distribution(value: dict[str, Any]) -> bool:
    return bool(value) and _DISTRIBUTION.issuperset(value)
