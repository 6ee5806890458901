"""The recipe reference: every setting of a recipe with what it takes and its default, read from the dataclasses."""

import ast
import dataclasses
import inspect
import textwrap
import typing
from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, Any, Literal

from warehouse_sim.config import to_mapping
from warehouse_sim.generation.recipe import Recipe
from warehouse_sim.ranges import range_of
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.layouts.site import Layout
from warehouse_sim.sensors.rgbd.depth.model import DepthModel
from warehouse_sim.sensors.rgbd.depth.models import MODELS

_FILLED_IN = {"name", "random_settings"}
"""Settings of the recipe and its scene that reading a file fills in."""
_INTRODUCTION = """# Recipe reference

Written from the settings of the code when this site is built. A *number or distribution* takes any form of
[random settings](../recipes.md#random-settings); every other number does so, too, once a scene, in `scene`.
"""


@dataclasses.dataclass(frozen=True)
class Section:
    """One group of settings."""

    path: str
    """Where it stands in a recipe, such as ``scene.lights``."""
    settings: type
    """Its dataclass."""


def sections(settings: type = Recipe, path: str = "") -> Iterator[Section]:
    """Yield the groups of settings, outer ones first, each once."""
    yield from _sections(settings, path, set())


def _sections(settings: type, path: str, seen: set[type]) -> Iterator[Section]:
    if settings in seen or settings is Distribution:
        return
    seen.add(settings)
    yield Section(path, settings)
    hints = typing.get_type_hints(settings, include_extras=True)
    for field in _fields(settings):
        inner_path = f"{path}.{field.name}".lstrip(".")
        for inner in _dataclasses_of(hints[field.name]):
            for place, kind in _kinds(inner, inner_path):
                yield from _sections(kind, place, seen)


def _kinds(settings: type, path: str) -> list[tuple[str, type]]:
    """Return the settings themselves, or those of each kind where a key says which."""
    if settings is Layout:  # the sides of a mixed one are layouts, too
        kinds = Layout.kinds if "(kind:" not in path else {}
        return [(f"{path} (kind: {name})", kind) for name, kind in sorted(kinds.items())]
    if settings is DepthModel:
        return [(f"{path} (model: {name})", kind) for name, kind in sorted(MODELS.items())]
    return [(path, settings)]


def _fields(settings: type) -> list[dataclasses.Field[Any]]:
    return [field for field in dataclasses.fields(settings) if field.init and field.name not in _FILLED_IN]


def _dataclasses_of(hint: Any) -> Iterator[type]:
    if isinstance(hint, type) and dataclasses.is_dataclass(hint):
        yield hint
    for inner in typing.get_args(hint):
        yield from _dataclasses_of(inner)


def descriptions(settings: type) -> dict[str, str]:
    """Return the docstring below each field, those of base classes included."""
    found: dict[str, str] = {}
    for cls in reversed(settings.__mro__[:-1]):
        try:
            body = ast.parse(textwrap.dedent(inspect.getsource(cls))).body[0]
        except (OSError, TypeError):
            continue
        lines = body.body if isinstance(body, ast.ClassDef) else []
        for line, after in pairwise(lines):
            text = ast.get_docstring(ast.Module([after], [])) if isinstance(after, ast.Expr) else None
            if text and isinstance(line, ast.AnnAssign) and isinstance(line.target, ast.Name):
                found[line.target.id] = " ".join(text.split())
    return found


def takes(hint: Any) -> str:
    """Return in words what a setting takes."""
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if origin is Annotated:
        allowed = range_of(hint)
        text = takes(hint.__origin__)
        return f"{text}, {allowed.text}" if allowed else text
    if origin is Literal:
        return ", ".join(f"`{name}`" for name in arguments)
    if origin is tuple:
        inner = takes(arguments[0])
        return f"list: {inner}" if arguments[-1] is Ellipsis else f"{len(arguments)} times: {inner}"
    if origin is dict:
        return f"by name: {takes(arguments[1])}"
    if arguments:
        return " or ".join("`null`" if one is type(None) else takes(one) for one in arguments)
    if hint is Distribution:
        return "number or distribution"
    plain = {str: "text", bool: "true or false", int: "whole number", float: "number", Any: "any"}
    return plain.get(hint) or "settings"


def default(field: dataclasses.Field[Any]) -> str:
    """Return a field's default as YAML writes it on one line, empty where it is a group of settings."""
    if field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING:
        return "required"
    value = field.default_factory() if field.default_factory is not dataclasses.MISSING else field.default
    if dataclasses.is_dataclass(value) and not isinstance(value, Distribution):
        return ""
    plain = to_mapping(value)
    text = {None: "null", True: "true", False: "false"}.get(plain) if not isinstance(plain, (list, dict)) else None
    if isinstance(plain, (int, float)) and not isinstance(plain, bool):
        text = f"{plain:g}"
    if isinstance(plain, dict):
        text = "{" + ", ".join(f"{key}: {item}" for key, item in plain.items()) + "}"
    return f"`{plain if text is None else text}`"


def page() -> str:
    """Return the page in Markdown."""
    parts = [_INTRODUCTION]
    for section in sections():
        hints, said = typing.get_type_hints(section.settings, include_extras=True), descriptions(section.settings)
        first = " ".join(inspect.cleandoc(section.settings.__doc__ or "").split("\n\n")[0].split())
        parts.append(f"## {section.path or 'the whole file'}\n\n{_plain(first)}\n")
        parts.append("| key | takes | default | meaning |\n|---|---|---|---|")
        for field in _fields(section.settings):
            row = (f"`{field.name}`", takes(hints[field.name]), default(field), _plain(said.get(field.name, "")))
            parts.append(f"| {' | '.join(cell.replace('|', '&#124;') for cell in row)} |")
        parts.append("")
    return "\n".join(parts)


def _plain(text: str) -> str:
    return text.replace("``", "`").replace("<", "&lt;").replace("*", "\\*")
