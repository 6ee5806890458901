"""Every name that a recipe or a command takes, by kind, each with one line on what it is."""

import re
from collections.abc import Callable, Iterable, Mapping
from importlib import import_module
from typing import Any

import yaml

from warehouse_sim.errors import UnknownNameError
from warehouse_sim.registry import Registry

_LEAST_OF_FAMILY = 8
Describe = Callable[[str, Any], str]
"""Returns a line on a name and what it stands for."""


def _shipped(folder: str, key: str) -> Describe:
    """Return what takes a line from a key of a shipped file."""

    def describe(name: str, _: Any) -> str:
        from warehouse_sim.resources import data_folder

        # Shipped files need no strict reader with places of errors, which takes ten times as long.
        loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
        text = (data_folder(folder.partition("/")[0]) / folder.partition("/")[2] / f"{name}.yaml").read_text("utf-8")
        return " ".join(str(yaml.load(text, loader).get(key, "")).split()).split(". ")[0].rstrip(".")

    return describe


def _bundled(name: str, _: Any) -> str:
    from warehouse_sim.estimators.registries import describe_model
    from warehouse_sim.resources import model_dir, model_names

    return f"bundled: {describe_model(model_dir(name))}" if name in model_names() else ""


def _nothing(name: str, item: Any) -> str:
    return ""


KINDS: dict[str, tuple[str, Describe]] = {
    "recipes": ("warehouse_sim.resources:recipe_names", _shipped("scenes", "description")),
    "rigs": ("warehouse_sim.sensors.rig.shipped:rig_comments", lambda name, text: str(text)),
    "cameras": (
        "warehouse_sim.sensors.rig.camera:CAMERA_PRESETS",
        lambda name, item: f"{item.width} x {item.height}, {item.hfov_deg:.0f} deg across",
    ),
    "depth": ("warehouse_sim.sensors.rgbd.depth.models:PRESETS", lambda name, item: item.kind.replace("_", " ")),
    "color": (
        "warehouse_sim.sensors.rgbd.color.config:COLOR_PRESETS",
        lambda name, item: "colour processing of a camera",
    ),
    "lidars": (
        "warehouse_sim.sensors.lidar.config:LIDAR_PRESETS",
        lambda name, item: f"lasers of {item.model}, {item.min_range:g}-{item.max_range:g} m",
    ),
    "sensors": ("warehouse_sim.sensors:SENSORS", _nothing),
    "light": (
        "warehouse_sim.scene.lighting.config:PRESETS",
        lambda name, item: f"{item.lux.low:g}-{item.lux.high:g} lx on the floor",
    ),
    "viewpoints": (
        "warehouse_sim.scene.viewpoints.mountings:MOUNTINGS",
        lambda name, item: f"camera {item.height.low:g}-{item.height.high:g} m high",
    ),
    "materials": ("warehouse_sim.catalog.materials:materials", _nothing),
    "objects": ("warehouse_sim.catalog:CATALOG", _nothing),
    "estimators": ("warehouse_sim.estimators.registries:ESTIMATORS", _bundled),
    "detectors": ("warehouse_sim.estimators.registries:DETECTORS", _nothing),
    "segmenters": ("warehouse_sim.estimators.registries:SEGMENTERS", _nothing),
    "formats": ("warehouse_sim.dataset.formats:FORMATS", _nothing),
    "backends": ("warehouse_sim.render:BACKENDS", _nothing),
    "suites": ("warehouse_sim.resources:suite_names", _shipped("benchmarks/suites", "question")),
}
"""What holds the names of each kind (a mapping, a registry, or what returns names), and what says a line on each."""
_FIRST = {"detectors": {"gt": "ground-truth masks", "gt-boxes": "ground-truth boxes"}}
_LAST = {"viewpoints": {"free": "anywhere on a shell around the target"}}


def names_of(kind: str) -> Mapping[str, str]:
    """Return the names of one kind with a line each; nothing of other kinds is imported.

    Raises:
        UnknownNameError: There is no such kind; lists them.
    """
    if kind not in KINDS:
        raise UnknownNameError("kind of names", kind, list(KINDS))
    place, describe = KINDS[kind]
    module, _, name = place.partition(":")
    held = getattr(import_module(module), name)
    held = held.names() if isinstance(held, Registry) else held() if callable(held) else held
    items = held if isinstance(held, Mapping) else dict.fromkeys(held)
    found = {name: describe(name, items[name]) for name in (sorted(items) if kind == "materials" else items)}
    return _FIRST.get(kind, {}) | found | _LAST.get(kind, {})


def folded(names: Iterable[str]) -> list[str]:
    """Return names with those of one family, by the letters before the first digit or _, as one: ``carton* (72)``."""
    families: dict[str, list[str]] = {}
    for name in names:
        families.setdefault(re.split(r"[\d_]", name, maxsplit=1)[0], []).append(name)
    short = []
    for family, members in families.items():
        short += [f"{family}* ({len(members)})"] if len(members) >= _LEAST_OF_FAMILY else members
    return sorted(short)
