"""Strict conversion between YAML and frozen dataclasses: an unknown key is an error that names its neighbour."""

import dataclasses
import difflib
import math
import sys
import types
import typing
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from warehouse_sim.errors import ConfigError, shown
from warehouse_sim.yaml_file import read_yaml

T = TypeVar("T")


def load_yaml(cls: type[T], path: Path, error: type[ConfigError] = ConfigError) -> T:
    """Read the YAML file at ``path`` into the dataclass ``cls``.

    Raises:
        error: The file is missing, is not YAML, or holds a key or value that ``cls`` does not take.
    """
    data = read_yaml(path, error)
    try:
        return from_mapping(cls, data if data is not None else {}, str(path))
    except ConfigError as problem:
        raise error(str(problem)) from problem


def from_mapping(cls: type[T], data: Any, where: str) -> T:
    """Build the dataclass ``cls`` from plain data, checking every key and type.

    A dataclass may define ``from_plain(cls, data, where)`` to read shorthand forms of itself; a field of another type
    may name such a function under ``from_plain`` in its metadata.

    Args:
        cls: Dataclass type.
        data: Mapping of field names to plain values.
        where: File and key path so far, for the messages.

    Raises:
        ConfigError: Unknown key, missing key, wrong type, or a value that the dataclass rejects.
    """
    if not isinstance(data, dict):
        raise ConfigError(f"{where}: expected a mapping of settings, found {shown(data)}")
    fields = {field.name: field for field in dataclasses.fields(cls) if field.init}  # type: ignore[arg-type]
    hints = typing.get_type_hints(cls)
    for key in data:
        if key not in fields:
            near = difflib.get_close_matches(_key_text(key), fields, n=1)
            hint = f"did you mean {near[0]!r}?" if near else f"known: {', '.join(fields)}"
            raise ConfigError(f"{where}: {_key_text(key)} is not a setting; {hint}")
    read = {key: fields[key].metadata.get("from_plain", partial(convert, hints[key])) for key in data}
    values = {key: read[key](value, f"{where}: {key}") for key, value in data.items()}
    for name, field in fields.items():
        required = field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING
        if required and name not in values:
            raise ConfigError(f"{where}: the setting {name!r} is missing")
    try:
        return cls(**values)
    except (ConfigError, ValueError) as problem:
        raise ConfigError(f"{where}: {problem}") from problem


def to_mapping(config: Any) -> Any:
    """Return plain data (mappings, lists, scalars) that ``from_mapping`` reads back to an equal object."""
    if hasattr(config, "to_plain"):
        return config.to_plain()
    if dataclasses.is_dataclass(config) and not isinstance(config, type):
        return {field.name: to_mapping(getattr(config, field.name)) for field in dataclasses.fields(config)}
    if isinstance(config, dict):
        return {key: to_mapping(value) for key, value in config.items()}
    if isinstance(config, (list, tuple)):
        return [to_mapping(value) for value in config]
    return str(config) if isinstance(config, Path) else config


def convert(hint: Any, value: Any, where: str) -> Any:
    """Return a plain value as what the type ``hint`` requires, without ``Annotated``.

    Raises:
        ConfigError: It is not of that type.
    """
    origin, args = typing.get_origin(hint), typing.get_args(hint)
    if hint is Any:
        return value
    if origin in (typing.Union, types.UnionType):
        return _convert_union(args, value, where)
    if origin is typing.Literal:
        if value not in args:
            raise ConfigError(f"{where} must be one of {', '.join(map(repr, args))}, found {shown(value)}")
        return value
    if origin is tuple:
        return _convert_tuple(args, value, where)
    if origin is dict:
        if not isinstance(value, dict):
            raise ConfigError(f"{where} must be a mapping, found {shown(value)}")
        names = {key: f"{where}.{_key_text(key)}" for key in value}
        return {
            convert(args[0], key, f"{names[key]}: the key"): convert(args[1], item, names[key])
            for key, item in value.items()
        }
    if hasattr(hint, "from_plain"):
        return hint.from_plain(value, where)
    if dataclasses.is_dataclass(hint):
        return from_mapping(typing.cast(type, hint), value, where)
    return _convert_scalar(hint, value, where)


def _convert_union(options: tuple[Any, ...], value: Any, where: str) -> Any:
    if value is None and type(None) in options:
        return None
    rest = [option for option in options if option is not type(None)]
    problems = []
    for option in rest:
        try:
            return convert(option, value, where)
        except ConfigError as problem:
            problems.append(problem)
    raise problems[-1]


def _convert_tuple(args: tuple[Any, ...], value: Any, where: str) -> tuple[Any, ...]:
    if not isinstance(value, (list, tuple)):
        raise ConfigError(f"{where} must be a list, found {shown(value)}")
    if len(args) == 2 and args[1] is Ellipsis:
        return tuple(convert(args[0], item, f"{where}[{i}]") for i, item in enumerate(value))
    if len(value) != len(args):
        raise ConfigError(f"{where} must have {len(args)} values, found {len(value)}")
    return tuple(convert(arg, item, f"{where}[{i}]") for i, (arg, item) in enumerate(zip(args, value, strict=True)))


def _convert_scalar(hint: Any, value: Any, where: str) -> Any:
    if hint is float and isinstance(value, (int, float)) and not isinstance(value, bool):
        huge = isinstance(value, int) and abs(value) > sys.float_info.max
        return math.inf if huge else float(value)
    if hint is Path and isinstance(value, str):
        return Path(value)
    if hint in (int, str, bool) and type(value) is hint:
        return value
    raise ConfigError(f"{where} must be {getattr(hint, '__name__', hint)}, found {shown(value)}")


def _key_text(key: Any) -> str:
    """Return a key as messages write it: as it is where it is a name."""
    return key if isinstance(key, str) and key.isidentifier() and shown(key) == repr(key) else shown(key)
