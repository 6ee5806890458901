"""Strict conversion between plain data and dataclasses: an unknown key is an error that names its neighbour.

Settings in YAML and records in JSON are read and written by it.
"""

import dataclasses
import difflib
import math
import sys
import types
import typing
from collections.abc import Callable, Mapping, Sized
from functools import cache, partial
from pathlib import Path
from typing import Any, TypeVar

from warehouse_sim.errors import ConfigError, not_listed, shown
from warehouse_sim.ranges import check_range, range_of
from warehouse_sim.yaml_file import read_yaml

T = TypeVar("T")
Reader = Callable[[Any, str], Any]
"""Takes a plain value and its place, for messages."""


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
    may name such a function under ``from_plain`` in its metadata, or its type is ``Annotated`` with an object that has
    it. Numbers keep to the ``Range`` of their type. Errors call keys what the class's ``called`` says, else a setting.

    Args:
        cls: Dataclass type.
        data: Mapping of field names to plain values.
        where: File and key path so far, for the messages.

    Raises:
        ConfigError: Unknown key, missing key, wrong type, or a value that the dataclass rejects.
    """
    if not isinstance(data, dict):
        raise ConfigError(f"{where}: expected a mapping of settings, found {shown(data)}")
    called, read, required = _readers(typing.cast(Any, cls))
    for key in data:
        if key not in read:
            near = difflib.get_close_matches(_key_text(key), read, n=1)
            hint = f"did you mean {near[0]!r}?" if near else f"known: {', '.join(read)}"
            raise ConfigError(f"{where}: {_key_text(key)} is not {called}; {hint}")
    for name in required:
        if name not in data:
            raise ConfigError(f"{where}: the {called.partition(' ')[2]} {name!r} is missing")
    values = {key: read[key](value, f"{where}: {key}") for key, value in data.items()}
    try:
        return cls(**values)
    except (ConfigError, ValueError) as problem:
        raise ConfigError(f"{where}: {problem}") from problem


@cache
def _readers(cls: Any) -> tuple[str, dict[str, Reader], tuple[str, ...]]:
    """Return what keys of a dataclass are called, what reads each, and which there must be."""
    fields = [field for field in dataclasses.fields(cls) if field.init]
    hints = typing.get_type_hints(cls, include_extras=True)
    read = {field.name: field.metadata.get("from_plain") or reader_of(hints[field.name]) for field in fields}
    nothing = dataclasses.MISSING
    required = (field.name for field in fields if field.default is nothing and field.default_factory is nothing)
    return getattr(cls, "called", "a setting"), read, tuple(required)


def to_mapping(config: Any) -> Any:
    """Return plain data (mappings, lists, scalars) that ``from_mapping`` reads back to an equal object.

    Arrays become nested lists and numpy's scalars Python's, without losing a digit. A field with ``omitted`` in its
    metadata is left out where it is empty or None; one may name under ``to_plain`` what makes it plain.
    """
    if hasattr(config, "to_plain"):
        return config.to_plain()
    if dataclasses.is_dataclass(config) and not isinstance(config, type):
        return fields_to_plain(config)
    if isinstance(config, Mapping):
        return {key: to_mapping(value) for key, value in config.items()}
    if isinstance(config, (list, tuple)):
        return [to_mapping(value) for value in config]
    if hasattr(config, "tolist"):
        # Adding zero turns the -0.0 of an array into 0.0 and changes nothing else.
        return (config + 0.0 if config.ndim and config.dtype.kind == "f" else config).tolist()
    return str(config) if isinstance(config, Path) else config


def fields_to_plain(config: Any) -> dict[str, Any]:
    """Return the fields of a dataclass as plain data, for a ``to_plain`` that changes some of it."""
    values = [(field, getattr(config, field.name)) for field in dataclasses.fields(config)]
    return {
        field.name: field.metadata.get("to_plain", to_mapping)(value)
        for field, value in values
        if not field.metadata.get("omitted") or not (value is None or (isinstance(value, Sized) and not len(value)))
    }


def convert(hint: Any, value: Any, where: str) -> Any:
    """Return a plain value as what the type ``hint`` requires.

    Raises:
        ConfigError: It is not of that type.
    """
    return reader_of(hint)(value, where)


def reader_of(hint: Any) -> Reader:
    """Return what reads plain values as what the type ``hint`` requires; made once, it reads many."""
    origin, args = typing.get_origin(hint), typing.get_args(hint)
    if hint is Any:
        return lambda value, where: value
    if origin is typing.Annotated:
        return _annotated_reader(hint)
    if origin in (typing.Union, types.UnionType):
        return _union_reader(args)
    if origin is typing.Literal:
        return partial(_read_literal, args)
    if origin is tuple:
        return _tuple_reader(args)
    if origin is dict:
        return partial(_read_mapping, reader_of(args[0]), reader_of(args[1]))
    if hasattr(hint, "from_plain"):
        return hint.from_plain
    if dataclasses.is_dataclass(hint):
        return partial(from_mapping, typing.cast(type, hint))
    return partial(_read_scalar, hint)


def _annotated_reader(hint: Any) -> Reader:
    for form in hint.__metadata__:
        if hasattr(form, "from_plain"):
            return form.from_plain
    read, allowed = reader_of(hint.__origin__), range_of(hint)
    if allowed is None:
        return read
    low, high = allowed.low, allowed.high

    def read_within(value: Any, where: str) -> Any:
        found = read(value, where)
        if type(found) in (int, float) and low <= found <= high:
            return found
        try:
            check_range(found, allowed, where)
        except ValueError as problem:
            raise ConfigError(str(problem)) from problem
        return found

    return read_within


def _union_reader(options: tuple[Any, ...]) -> Reader:
    readers = [reader_of(option) for option in options if option is not type(None)]

    def read(value: Any, where: str) -> Any:
        if value is None and type(None) in options:
            return None
        problems = []
        for one in readers:
            try:
                return one(value, where)
            except ConfigError as problem:
                problems.append(problem)
        raise problems[-1]

    return read


def _tuple_reader(args: tuple[Any, ...]) -> Reader:
    is_open = len(args) == 2 and args[1] is Ellipsis
    readers = [reader_of(arg) for arg in (args[:1] if is_open else args)]

    def read(value: Any, where: str) -> tuple[Any, ...]:
        if not isinstance(value, (list, tuple)):
            raise ConfigError(f"{where} must be a list, found {shown(value)}")
        if not is_open and len(value) != len(readers):
            raise ConfigError(f"{where} must have {len(readers)} values, found {len(value)}")
        each = readers * len(value) if is_open else readers
        return tuple(one(item, f"{where}[{i}]") for i, (one, item) in enumerate(zip(each, value, strict=True)))

    return read


def _read_literal(allowed: tuple[Any, ...], value: Any, where: str) -> Any:
    if value not in allowed:
        raise ConfigError(not_listed(where, value, allowed))
    return value


def _read_mapping(read_key: Reader, read_item: Reader, value: Any, where: str) -> dict[Any, Any]:
    if not isinstance(value, dict):
        raise ConfigError(f"{where} must be a mapping, found {shown(value)}")
    names = {key: f"{where}.{_key_text(key)}" for key in value}
    return {read_key(key, f"{names[key]}: the key"): read_item(item, names[key]) for key, item in value.items()}


def _read_scalar(kind: Any, value: Any, where: str) -> Any:
    if type(value) is kind and kind in (float, int, str, bool):
        return value
    if kind is float and isinstance(value, (int, float)) and not isinstance(value, bool):
        huge = isinstance(value, int) and abs(value) > sys.float_info.max
        return math.inf if huge else float(value)
    if kind is Path and isinstance(value, str):
        return Path(value)
    raise ConfigError(f"{where} must be {getattr(kind, '__name__', kind)}, found {shown(value)}")


def _key_text(key: Any) -> str:
    """Return a key as messages write it: as it is where it is a name."""
    return key if isinstance(key, str) and key.isidentifier() and shown(key) == repr(key) else shown(key)
