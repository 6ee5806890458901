"""Calls with arguments that a function or class does not take: an error of ours that names those it takes."""

import inspect
from collections.abc import Callable, Mapping
from difflib import get_close_matches
from functools import wraps
from typing import Any, ParamSpec, TypeVar

from warehouse_sim.errors import InputError

P = ParamSpec("P")
R = TypeVar("R")
T = TypeVar("T")
_VARIADIC = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)


def clear_arguments(cls: type[T]) -> type[T]:
    """Make a class say which arguments it takes when it is made with others; it stands above ``@dataclass``."""
    cls.__init__ = clear_call(cls.__init__, cls.__name__)  # type: ignore[method-assign]
    return cls


def clear_call(function: Callable[P, R], name: str = "") -> Callable[P, R]:
    """Make a function say which arguments it takes when it is called with others; a call that fits costs nothing.

    Args:
        function: The function.
        name: What messages call it; its own name by default.
    """
    signature = inspect.signature(function)

    @wraps(function)
    def call(*args: P.args, **kwargs: P.kwargs) -> R:
        try:
            return function(*args, **kwargs)
        except TypeError:
            bind(signature, name or function.__qualname__.removesuffix(".__init__"), args, kwargs)
            raise

    return call


def bind(
    signature: inspect.Signature, name: str, args: tuple[Any, ...], kwargs: Mapping[str, Any]
) -> inspect.BoundArguments:
    """Return the arguments of a call by the names of the parameters.

    Raises:
        InputError: The function does not take them.
    """
    try:
        return signature.bind(*args, **kwargs)
    except TypeError as problem:
        raise InputError(f"{name}: {problem}; {_usage(signature, kwargs)}") from None


def _usage(signature: inspect.Signature, given: Mapping[str, Any]) -> str:
    """Return what a function takes, and the name that was probably meant."""
    taken = [item for item in signature.parameters.values() if item.name not in ("self", "cls")]
    names = [item.name for item in taken if item.kind not in _VARIADIC]
    meant = [near[0] for key in given if key not in names and (near := get_close_matches(key, names, 1))]
    hint = f"did you mean {meant[0]!r}? " if meant else ""
    stars: dict[Any, str] = {inspect.Parameter.VAR_POSITIONAL: "*", inspect.Parameter.VAR_KEYWORD: "**"}
    return f"{hint}it takes {', '.join(stars.get(item.kind, '') + item.name for item in taken) or 'nothing'}"
