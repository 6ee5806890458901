"""Settings that a recipe randomises: where a number is expected, a distribution may stand, and a choice for a name.

``Distribution`` settings are sampled again for every object. All other settings are sampled once a scene; this module
finds them and replaces each by one value.
"""

import dataclasses
import types
import typing
from collections.abc import Iterator
from copy import deepcopy
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal

import numpy as np

from warehouse_sim.config import convert
from warehouse_sim.errors import ConfigError, shown
from warehouse_sim.ranges import Range, range_of
from warehouse_sim.scene.distribution import Distribution

End = Literal["low", "high"]


@dataclass(frozen=True)
class Choice:
    """How to draw one name or switch; in YAML ``{choices[, weights]}``."""

    values: tuple[Any, ...]
    """What it is made from."""
    weights: tuple[float, ...] = ()
    """Relative weights; equal when empty."""

    @classmethod
    def from_plain(cls, data: Any, where: str) -> "Choice":
        """Read ``{choices[, weights]}``.

        Raises:
            ConfigError: There is nothing to choose from, or the weights do not fit.
        """
        values = data.get("choices")
        if set(data) - {"choices", "weights"} or not isinstance(values, list) or not values:
            raise ConfigError(f"{where} must be a value or {{choices, weights}}, found {shown(data)}")
        numbers = Distribution.from_plain(data | {"choices": list(range(len(values)))}, where)
        return cls(tuple(values), numbers.weights)

    def to_plain(self) -> dict[str, Any]:
        """Return what ``from_plain`` reads back."""
        return {"choices": list(self.values), **({"weights": list(self.weights)} if self.weights else {})}

    def sample(self, rng: np.random.Generator) -> Any:
        """Return one of the values."""
        fractions = np.array(self.weights) / sum(self.weights) if self.weights else None
        return self.values[int(rng.choice(len(self.values), p=fractions))]


@dataclass(frozen=True)
class RandomSetting:
    """One setting of a recipe that is sampled for each scene."""

    path: tuple[str | int, ...]
    """Keys and list positions that lead to it."""
    kind: Literal["float", "int", "name"]
    """What a draw of it must be."""
    source: Distribution | Choice
    """Where draws come from."""

    @property
    def name(self) -> str:
        """The path in one word, "layout.bays"."""
        return ".".join(map(str, self.path))

    def sample(self, rng: np.random.Generator) -> Any:
        """Return one value."""
        if isinstance(self.source, Distribution) and self.kind == "int":
            return self.source.sample_count(rng)
        return self.source.sample(rng)

    def end(self, end: End) -> Any:
        """Return the smallest or the largest value; the mean where there is none."""
        if isinstance(self.source, Choice):
            return self.source.values[0 if end == "low" else -1]
        value = getattr(self.source, end)
        value = value if np.isfinite(value) else self.source.mean
        return round(value) if self.kind == "int" else value


def find_random_settings(cls: type, data: Any, where: str) -> tuple[RandomSetting, ...]:
    """Return the random settings in plain ``data`` of the dataclass ``cls``, in order of their names.

    Raises:
        ConfigError: A distribution or choice cannot be read.
    """
    return tuple(sorted(_walk_fields(cls, data, (), where), key=lambda setting: setting.name))


def with_values(data: Any, values: list[tuple[tuple[str | int, ...], Any]]) -> Any:
    """Return a copy of plain ``data`` with the value of each path replaced."""
    closed = deepcopy(data)
    for path, value in values:
        parent = closed
        for key in path[:-1]:
            parent = parent[key]
        parent[path[-1]] = value
    return closed


def _walk(
    hint: Any, data: Any, path: tuple[str | int, ...], where: str, allowed: Range | None = None
) -> Iterator[RandomSetting]:
    origin, args = typing.get_origin(hint), typing.get_args(hint)
    if origin is Annotated:
        yield from _walk(args[0], data, path, where, range_of(hint))
    elif origin in (typing.Union, types.UnionType):
        hint = next(option for option in args if option is not type(None))
        yield from _walk(hint, data, path, where, allowed)
    elif origin is tuple and isinstance(data, list):
        for index, item in enumerate(data):
            inner = args[0] if args[-1] is Ellipsis else args[min(index, len(args) - 1)]
            yield from _walk(inner, item, (*path, index), f"{where}[{index}]", allowed)
    elif not isinstance(data, dict):
        return
    elif hasattr(hint, "type_of"):
        yield from _walk_fields(hint.type_of(data, where), data, path, where)
    elif hasattr(hint, "from_plain"):
        return
    elif dataclasses.is_dataclass(hint):
        yield from _walk_fields(hint, data, path, where)
    elif hint in (int, float):
        yield RandomSetting(path, "int" if hint is int else "float", _number_within(hint, data, where, allowed))
    elif hint in (str, bool) or origin is Literal:
        choice = Choice.from_plain(data, where)
        for value in choice.values:
            convert(hint, value, where)
        yield RandomSetting(path, "name", choice)


def _walk_fields(cls: Any, data: dict[str, Any], path: tuple[str | int, ...], where: str) -> Iterator[RandomSetting]:
    hints = typing.get_type_hints(cls, include_extras=True)
    names = {field.name for field in dataclasses.fields(cls)}
    for key, value in data.items():
        if key in names:
            yield from _walk(hints[key], value, (*path, key), f"{where}: {key}")


def _number_within(hint: type, data: Any, where: str, allowed: Range | None) -> Distribution:
    """Return the distribution of a random number, of which all draws are in the setting's range."""
    source = Distribution.from_plain(data, where)
    if allowed is not None:
        try:
            source.check_within(replace(allowed, whole=hint is int), where)
        except ValueError as problem:
            raise ConfigError(str(problem)) from problem
    return source
