"""Check the arguments of a public name: what does not fit is an error that says what does."""

import inspect
import re
import sys
import types
import typing
from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from numbers import Integral, Real
from os import PathLike
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import numpy as np

from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import InputError, shown
from warehouse_sim.ranges import range_of
from warehouse_sim.signature import bind

P = ParamSpec("P")
T = TypeVar("T")
_LONGEST_NAME, _LONGEST_PATH = 255, 4000
"""Bytes of a file's name and of its path."""
_WORDS: dict[Any, str] = {
    str: "text", int: "a whole number", float: "a number", bool: "True or False", Path: "a path", None: "None",
    Any: "anything", np.ndarray: "an array",
}  # fmt: skip


def checked(function: Callable[P, T]) -> Callable[P, T]:
    """Make a function reject arguments that it does not take, or that are of another type than it says.

    It stands directly above ``def``, below ``@classmethod`` and ``@property``. Numbers keep to the ``Range`` of their
    annotation. What a type checker alone knows (protocols, type variables, strings that cannot be resolved) passes.
    """
    signature = inspect.signature(function)
    hints: dict[str, Any] = {}

    @wraps(function)
    def call(*args: P.args, **kwargs: P.kwargs) -> T:
        name = function.__qualname__.removesuffix(".__init__")
        if not hints:
            hints.update(_hints(function))
        bound = bind(signature, name, args, kwargs)
        for key, value in bound.arguments.items():
            _check(name, signature.parameters[key], value, hints.get(key, Any))
        return function(*args, **kwargs)

    return call


def settings_of(default: T, given: Mapping[str, Any], where: str) -> T:
    """Return settings with some of them given by name, as options are on the command line.

    Args:
        default: All settings.
        given: Values by name; settings within settings are mappings or settings themselves.
        where: What takes them, for messages.

    Raises:
        ConfigError: There is no such setting, or a value does not fit.
    """
    plain = {
        name: to_mapping(value.item() if isinstance(value, np.generic) else value) for name, value in given.items()
    }
    return from_mapping(type(default), to_mapping(default) | plain, where)


def fits(value: Any, hint: Any) -> bool:
    """Return whether a value is of a type, containers item by item; whole numbers are numbers, True is none."""
    origin, args = typing.get_origin(hint), typing.get_args(hint)
    if hint is Any:
        return True
    if origin is typing.Annotated:
        return fits(value, args[0])
    if origin in (typing.Union, types.UnionType):
        return any(fits(value, option) for option in args)
    if origin is typing.Literal:
        return any(type(value) is type(option) and value == option for option in args)
    if hint is float or hint is int:
        kind = Real if hint is float else Integral
        return isinstance(value, kind) and not isinstance(value, (bool, np.bool_))
    if hint is Path:
        return isinstance(value, PathLike)
    if hint is None or hint is type(None):
        return value is None
    if hint is bool:
        return isinstance(value, (bool, np.bool_))
    if origin is not None:
        return _fits_container(value, origin, args)
    if not isinstance(hint, type) or (getattr(hint, "_is_protocol", False) and not _at_run_time(hint)):
        return True
    return isinstance(value, hint)


def _fits_container(value: Any, origin: Any, args: tuple[Any, ...]) -> bool:
    if origin is tuple and args[-1:] != (...,):
        listed = isinstance(value, (tuple, list, np.ndarray)) and len(value) == len(args)
        return listed and all(fits(item, hint) for item, hint in zip(value, args, strict=True))
    if origin in (tuple, list, Sequence):
        listed = isinstance(value, (Sequence, np.ndarray)) and not isinstance(value, (str, bytes))
        return listed and all(fits(item, args[0]) for item in value)
    if origin in (dict, Mapping):
        known = isinstance(value, Mapping)
        return known and all(fits(key, args[0]) and fits(item, args[1]) for key, item in value.items())
    if origin is Callable:
        return callable(value)
    return not isinstance(origin, type) or isinstance(value, origin)


def _check(name: str, parameter: inspect.Parameter, value: Any, hint: Any) -> None:
    if parameter.kind is inspect.Parameter.VAR_KEYWORD:
        items = {key: item for key, item in value.items()}
    elif parameter.kind is inspect.Parameter.VAR_POSITIONAL:
        items = {f"{parameter.name}[{index}]": item for index, item in enumerate(value)}
    else:
        items = {parameter.name: value}
    for key, item in items.items():
        if not fits(item, hint):
            raise InputError(f"{name}: {key} must be {_described(hint)}, found {shown(item)}")
        if not _is_plain(item):
            raise InputError(f"{name}: {key} must be text that UTF-8 can hold, found {shown(item)}")
        _check_range(f"{name}: {key}", item, hint)
        if Path in typing.get_args(hint) and isinstance(item, (str, PathLike)):
            _check_path(f"{name}: {key}", str(item))


def _is_plain(value: Any) -> bool:
    """Return whether text, or every text of a list, has no half of a character, which no file can hold."""
    if isinstance(value, (list, tuple)):
        return all(map(_is_plain, value))
    return not isinstance(value, str) or value.isascii() or not re.search("[\ud800-\udfff]", value)


def _check_path(where: str, path: str) -> None:
    """Reject what no file can be called, and what would be the current folder or break messages into lines."""
    if not path.strip() or not path.isprintable():
        raise InputError(f"{where} must be a path of printable characters, found {shown(path)}")
    if max(map(len, path.encode().split(b"/"))) > _LONGEST_NAME or len(path.encode()) > _LONGEST_PATH:
        raise InputError(f"{where} is too long for a path, found {shown(path)}")


def _check_range(where: str, value: Any, hint: Any) -> None:
    allowed = range_of(hint) or next((found for option in typing.get_args(hint) if (found := range_of(option))), None)
    if allowed is not None and isinstance(value, Real) and float(value) not in allowed:
        raise InputError(f"{where} must be {allowed.text}, found {value}")
    numbers = value if isinstance(value, (tuple, list)) else [value]
    if any(isinstance(number, Real) and not np.isfinite(float(number)) for number in numbers):
        raise InputError(f"{where} must be finite, found {value}")


def _described(hint: Any) -> str:
    """Return the type as a person says it."""
    origin, args = typing.get_origin(hint), typing.get_args(hint)
    if origin is typing.Annotated:
        return _described(args[0])
    if origin in (typing.Union, types.UnionType):
        *first, last = dict.fromkeys(_described(option) for option in args)
        return f"{', '.join(first)} or {last}" if first else last
    if origin is typing.Literal:
        return f"one of {', '.join(map(repr, args))}"
    if origin is tuple and args[-1:] != (...,):
        return f"({', '.join(map(_described, args))})"
    if origin in (tuple, list, Sequence):
        return f"a list of {_described(args[0])}"
    if origin in (dict, Mapping):
        return f"a mapping from {_described(args[0])} to {_described(args[1])}"
    if origin is Callable:
        return "a function"
    plain = None if hint is type(None) else hint
    return _WORDS.get(plain) or str(getattr(plain, "__name__", plain))


def _hints(function: Callable[..., Any]) -> dict[str, Any]:
    """Return the types of parameters; what names something that only type checkers import is left out."""
    found: dict[str, Any] = {}
    for name, hint in function.__annotations__.items():
        only = types.SimpleNamespace(__annotations__={name: hint}, __module__=function.__module__)
        try:
            found |= typing.get_type_hints(only, vars(sys.modules[function.__module__]), include_extras=True)
        except NameError:
            found[name] = Any
    return found


def _at_run_time(protocol: Any) -> bool:
    return bool(getattr(protocol, "_is_runtime_protocol", False))
