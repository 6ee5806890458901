"""What a setting takes, declared beside it: ``Annotated[float, Range(0.1, 10, "m")]``, ``Literal["cpu", "cuda"]``.

Every number of a settings class has its ``Range``; ``@ranged`` makes the class keep to them and to the names of a
``Literal``, wherever its values come from: a file, the command line or Python.
"""

import math
import typing
from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import cache, wraps
from numbers import Real
from typing import Annotated, Any, Literal, TypeVar

from warehouse_sim.errors import ConfigError, not_listed

T = TypeVar("T")
_FRACTIONS = (30, 45, 60, 90, 120, 135, 180, 270, 360)
"""Angles that people write as a fraction of pi (deg)."""


@dataclass(frozen=True)
class Range:
    """The numbers from ``low`` to ``high``, both included; NaN is never among them."""

    low: float
    """Smallest number."""
    high: float
    """Largest number."""
    unit: str = ""
    """Unit of both, for messages."""
    whole: bool = False
    """Whether only whole numbers are drawn; for distributions, since the type ``int`` says it of a number."""

    def __str__(self) -> str:
        return f"{_digits(self.low)}{'-' if self.low >= 0 else ' to '}{_digits(self.high)}"

    def __contains__(self, number: float) -> bool:
        return self.low <= number <= self.high

    @property
    def text(self) -> str:
        """The range with its unit."""
        return f"{self} {self.unit}".rstrip()


Fraction = Annotated[float, Range(0, 1)]
"""A part of a whole, or a probability."""
Seed = Annotated[int, Range(0, 2**63 - 1)]
"""Where random numbers begin."""


def degrees_of_radians(value: float) -> int | None:
    """Return the degrees of a number that is a fraction of pi to three digits (3.14, 0.785), as angles in rad are."""
    return next((deg for deg in _FRACTIONS if math.isclose(abs(value), math.radians(deg), rel_tol=6e-4)), None)


def ranged(cls: type[T]) -> type[T]:
    """Make a dataclass check its settings before its own ``__post_init__``, and all that it rejects a ConfigError.

    It stands below ``@dataclass``.
    """
    relations: Callable[[Any], None] = getattr(cls, "__post_init__", lambda settings: None)

    @wraps(relations)
    def check(settings: Any) -> None:
        try:
            check_ranges(settings)
            _check_names(settings)
            relations(settings)
        except ValueError as problem:
            raise ConfigError(str(problem)) from problem

    cls.__post_init__ = check  # type: ignore[attr-defined]
    return cls


def check_ranges(settings: Any) -> None:
    """Reject numbers of a dataclass that are outside of their ranges.

    Raises:
        ValueError: Names the setting, its range and what was found.
    """
    kind: Any = type(settings)
    for name, allowed in ranges_of(kind).items():
        check_range(getattr(settings, name), allowed, name)


@cache
def ranges_of(cls: Any) -> dict[str, Range]:
    """Return the ranges that are declared for the fields of a dataclass, by their names."""
    hints = typing.get_type_hints(cls, include_extras=True)
    declared = {item.name: _declared(hints[item.name]) for item in fields(cls)}
    return {name: allowed for name, allowed in declared.items() if allowed is not None}


def _check_names(settings: Any) -> None:
    """Reject a text that is none of the names which a field's ``Literal`` lists.

    Raises:
        ValueError: Names the setting, what there is and what was found.
    """
    kind: Any = type(settings)
    for name, known in _names_of(kind).items():
        value = getattr(settings, name)
        if isinstance(value, str) and value not in known:
            raise ValueError(not_listed(name, value, known))


@cache
def _names_of(cls: Any) -> dict[str, tuple[str, ...]]:
    """Return the names that fields of a dataclass take, where these take no other text."""
    hints = typing.get_type_hints(cls)
    listed = {item.name: _listed(hints[item.name]) for item in fields(cls)}
    return {name: known for name, known in listed.items() if known}


def _listed(hint: Any) -> tuple[str, ...]:
    options = (hint,) if typing.get_origin(hint) is Literal else typing.get_args(hint)
    literals = [option for option in options if typing.get_origin(option) is Literal]
    names = tuple(name for option in literals for name in typing.get_args(option) if isinstance(name, str))
    return () if str in options else names


def range_of(hint: Any) -> Range | None:
    """Return the ``Range`` that an ``Annotated`` type holds itself."""
    return next((item for item in getattr(hint, "__metadata__", ()) if isinstance(item, Range)), None)


def _declared(hint: Any) -> Range | None:
    """Return the range of a type or of one of its options: ``Annotated[float, Range(0, 1)] | None``."""
    options = (hint, *typing.get_args(hint))
    return next((found for option in options if (found := range_of(option)) is not None), None)


def check_range(value: Any, allowed: Range, name: str) -> None:
    """Reject a number, or a container with a number, outside of its range; nothing is no number.

    What is drawn from a distribution rejects, by its ``check_within``, to draw numbers outside of it.
    """
    if isinstance(value, (tuple, list)):
        for index, item in enumerate(value):
            check_range(item, allowed, f"{name}[{index}]")
    elif isinstance(value, Real):
        if float(value) not in allowed:
            raise ValueError(f"{name} must be {allowed.text}, found {value}")
    elif value is not None and not isinstance(value, str):  # a name in place of a number
        value.check_within(allowed, name)


def _digits(number: float) -> str:
    """Return a number without an exponent, in groups of three digits."""
    return f"{number:,}" if isinstance(number, int) else f"{number:,.9f}".rstrip("0").rstrip(".")
