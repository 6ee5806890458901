"""Every name that a recipe or a command takes, by kind, each with one line on what it is."""

import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import yaml

from warehouse_sim.errors import UnknownNameError

_LEAST_OF_FAMILY = 8


def kinds() -> dict[str, Callable[[], Mapping[str, str]]]:
    """Return what gives the names of each kind; nothing is imported before it is called."""
    return {
        "recipes": _recipes,
        "rigs": _rigs,
        "cameras": _cameras,
        "depth": _depth,
        "color": _color,
        "lidars": _lidars,
        "sensors": _sensors,
        "light": _light,
        "viewpoints": _viewpoints,
        "materials": _materials,
        "objects": _objects,
        "estimators": _estimators,
        "detectors": _detectors,
        "segmenters": _segmenters,
        "formats": _formats,
        "backends": _backends,
        "suites": _suites,
    }


def names_of(kind: str) -> Mapping[str, str]:
    """Return the names of one kind, a key of ``kinds``, with a line each."""
    return kinds()[kind]()


def require_kind(kind: str) -> None:
    """Reject what is no kind of names.

    Raises:
        UnknownNameError: Lists the kinds.
    """
    if kind not in kinds():
        raise UnknownNameError("kind of names", kind, list(kinds()))


def folded(names: Iterable[str]) -> list[str]:
    """Return names with those of one family, by the letters before the first digit or _, as one: ``carton* (72)``."""
    families: dict[str, list[str]] = {}
    for name in names:
        families.setdefault(re.split(r"[\d_]", name, maxsplit=1)[0], []).append(name)
    short = []
    for family, members in families.items():
        short += [f"{family}* ({len(members)})"] if len(members) >= _LEAST_OF_FAMILY else members
    return sorted(short)


def _first_sentence(text: Any) -> str:
    return " ".join(str(text or "").split()).split(". ")[0].rstrip(".")


def _described(names: list[str], path: Callable[[str], Any], key: str) -> dict[str, str]:
    # Shipped files need no strict reader with places of errors, which takes ten times as long.
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    found = {name: yaml.load(path(name).read_text(encoding="utf-8"), loader) for name in names}
    return {name: _first_sentence(data.get(key, "")) for name, data in found.items() if isinstance(data, dict)}


def _recipes() -> Mapping[str, str]:
    from warehouse_sim.resources import find_recipe, recipe_names

    return _described(recipe_names(), find_recipe, "description")


def _rigs() -> Mapping[str, str]:
    from warehouse_sim.sensors.rig.shipped import rig_comments

    return rig_comments()


def _cameras() -> Mapping[str, str]:
    from warehouse_sim.sensors.rig.camera import CAMERA_PRESETS

    return {
        name: f"{item.width} x {item.height}, {item.hfov_deg:.0f} deg across" for name, item in CAMERA_PRESETS.items()
    }


def _depth() -> Mapping[str, str]:
    from warehouse_sim.sensors.rgbd.depth.models import PRESETS

    return {name: f"{model.kind.replace('_', ' ')}" for name, model in PRESETS.items()}


def _color() -> Mapping[str, str]:
    from warehouse_sim.sensors.rgbd.color.config import COLOR_PRESETS

    return dict.fromkeys(COLOR_PRESETS, "colour processing of a camera")


def _lidars() -> Mapping[str, str]:
    from warehouse_sim.sensors.lidar.config import LIDAR_PRESETS

    return {
        name: f"lasers of {item.model}, {item.min_range:g}-{item.max_range:g} m" for name, item in LIDAR_PRESETS.items()
    }


def _sensors() -> Mapping[str, str]:
    from warehouse_sim.sensors import SENSORS

    return dict.fromkeys(SENSORS.names(), "")


def _light() -> Mapping[str, str]:
    from warehouse_sim.scene.lighting.presets import PRESETS

    return {name: f"{item.lux.low:g}-{item.lux.high:g} lx on the floor" for name, item in PRESETS.items()}


def _viewpoints() -> Mapping[str, str]:
    from warehouse_sim.scene.viewpoints.mountings import MOUNTINGS

    return {name: f"camera {item.height.low:g}-{item.height.high:g} m high" for name, item in MOUNTINGS.items()} | {
        "free": "anywhere on a shell around the target"
    }


def _materials() -> Mapping[str, str]:
    from warehouse_sim.catalog.materials import materials

    return dict.fromkeys(sorted(materials()), "")


def _objects() -> Mapping[str, str]:
    from warehouse_sim.catalog import CATALOG

    return dict.fromkeys(CATALOG.names(), "")


def _estimators() -> Mapping[str, str]:
    from warehouse_sim.estimators.registries import ESTIMATORS, describe_model
    from warehouse_sim.resources import model_dir, model_names

    bundled = model_names()
    return {
        name: f"bundled: {describe_model(model_dir(name))}" if name in bundled else "" for name in ESTIMATORS.names()
    }


def _detectors() -> Mapping[str, str]:
    from warehouse_sim.estimators.registries import DETECTORS

    return {"gt": "ground-truth masks", "gt-boxes": "ground-truth boxes"} | dict.fromkeys(DETECTORS.names(), "")


def _segmenters() -> Mapping[str, str]:
    from warehouse_sim.estimators.registries import SEGMENTERS

    return dict.fromkeys(SEGMENTERS.names(), "")


def _formats() -> Mapping[str, str]:
    from warehouse_sim.dataset.formats import FORMATS

    return dict.fromkeys(FORMATS.names(), "")


def _backends() -> Mapping[str, str]:
    from warehouse_sim.render import BACKENDS

    return dict.fromkeys(BACKENDS.names(), "")


def _suites() -> Mapping[str, str]:
    from warehouse_sim.resources import data_folder, suite_names

    return _described(suite_names(), lambda name: data_folder("benchmarks") / "suites" / f"{name}.yaml", "question")
