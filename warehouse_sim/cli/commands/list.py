"""``warehouse-sim list``: the names that recipes and commands take, by kind, each with one line on what it is."""

import json as json_text
import re
import shutil
import sys
import textwrap
from collections.abc import Callable, Iterable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

import tyro
import yaml

from warehouse_sim.cli.checks import require_free
from warehouse_sim.cli.console import count_progress, finish, require_ending
from warehouse_sim.errors import InputError, UnknownNameError
from warehouse_sim.optional import require_extra
from warehouse_sim.registry import Registry


def list_names(
    kind: tyro.conf.Positional[str | None] = None,
    objects: tyro.conf.Positional[tuple[str, ...]] = (),
    json: bool = False,
    out: Path | None = None,
) -> None:
    """Show recipes, rigs, sensors, presets, catalog objects, estimators, formats, backends and suites by name.

    With a kind, every name gets a line: recipes, rigs, cameras, depth, color, lidars, sensors, light, viewpoints,
    materials, objects, estimators, detectors, segmenters, formats, backends, suites.

    Args:
        kind: Show one kind; all by default, with the sizes of catalog objects folded to families.
        objects: With kind objects and --out, which ones; all by default.
        json: Print JSON: a list of names by kind.
        out: With kind objects, PNG file with a picture of each and its size.
    """
    if out is not None or objects:
        if kind != "objects" or out is None or json:
            raise InputError(
                "names after KIND and --out draw catalog objects: list objects [OBJECT ...] --out FILE.png"
            )
        require_ending("--out", out, ".png")
        require_free(out, overwrite=True)
        _draw(out, objects)
        return
    if json:
        print(json_text.dumps({name: sorted(names_of(name)) for name in ([kind] if kind else KINDS)}, indent=1))
        return
    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else 140
    if kind is not None:
        found = names_of(kind)
        left = max((len(name) for name in found), default=0)
        for name, text in found.items():
            print(textwrap.shorten(f"{name:{left}}  {text}", width, placeholder=" ...") if text else name)
        return
    for name in KINDS:
        names = folded(names_of(name)) if name in ("objects", "materials") else list(names_of(name))
        print(
            textwrap.fill(
                ", ".join(names), width, initial_indent=f"{name:12}", subsequent_indent=" " * 12, break_on_hyphens=False
            )
        )
    print("next:   warehouse-sim list KIND, or warehouse-sim preview demo")


def _draw(sheet: Path, objects: tuple[str, ...]) -> None:
    require_extra("generate", "to draw objects")
    from warehouse_sim.generation.catalog_sheet import render_catalog_sheet

    with count_progress("objects") as progress:
        render_catalog_sheet(sheet, objects or None, progress=progress)
    finish(sheet, "preview", "demo")


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


def _with_bundled(names: Iterable[str]) -> list[str]:
    """Return names of methods with those of other bundled weights of theirs, which begin with the method's name."""
    from warehouse_sim.resources import model_names

    methods = {*names}
    return sorted(
        methods | {model for model in model_names() if model.startswith(tuple(f"{name}-" for name in methods))}
    )


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
    "detectors": ("warehouse_sim.estimators.registries:DETECTORS", _bundled),
    "segmenters": ("warehouse_sim.estimators.registries:SEGMENTERS", _bundled),
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
    if describe is _bundled:
        held = _with_bundled(held)
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
