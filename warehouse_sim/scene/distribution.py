"""A number that a recipe leaves open: a constant, a range, a bell or a choice."""

import math
from dataclasses import dataclass
from functools import cached_property
from statistics import NormalDist
from typing import Any, Literal

import numpy as np

from warehouse_sim.errors import ConfigError, shown
from warehouse_sim.ranges import Range

_KEYS = {
    "uniform": ({"min", "max"}, set[str]()),
    "normal": ({"mean", "std"}, {"min", "max"}),
    "choices": ({"choices"}, {"weights"}),
}


_WEIGHTS = Range(0, 1_000_000)


@dataclass(frozen=True)
class Distribution:
    """How to draw one number.

    In YAML: a number, ``{min, max}``, ``{mean, std[, min, max]}`` or ``{choices[, weights]}``.
    """

    kind: Literal["constant", "uniform", "normal", "choices"]
    """Family."""
    low: float = -np.inf
    """Smallest value; the value itself for a constant."""
    high: float = np.inf
    """Largest value; the value itself for a constant."""
    mean: float = 0.0
    """Mean of the bell before it is cut off at ``low`` and ``high``."""
    std: float = 0.0
    """Standard deviation of the bell, >= 0."""
    values: tuple[float, ...] = ()
    """What a choice is made from."""
    weights: tuple[float, ...] = ()
    """Relative weights of the choices; equal when empty."""

    def __post_init__(self) -> None:
        if self.low > self.high:
            raise ValueError(f"min must not exceed max, found {self.low} > {self.high}")
        if self.std < 0:
            raise ValueError(f"std must be >= 0, found {self.std}")
        if self.kind == "normal" and not self.low <= self.mean <= self.high:
            raise ValueError(f"mean {self.mean} must lie between min {self.low} and max {self.high}")
        if self.kind == "choices" and not self.values:
            raise ValueError("choices must list at least one number")
        if self.weights and (len(self.weights) != len(self.values) or not _can_weigh(self.weights)):
            raise ValueError(
                f"weights must be one number of {_WEIGHTS} per choice and not all 0, found {shown(list(self.weights))}"
            )

    @classmethod
    def constant(cls, value: float) -> "Distribution":
        """Return the distribution that always gives ``value``."""
        return cls("constant", low=value, high=value)

    @classmethod
    def uniform(cls, low: float, high: float) -> "Distribution":
        """Return the even distribution between ``low`` and ``high``."""
        return cls("uniform", low=low, high=high)

    @classmethod
    def normal(cls, mean: float, std: float, low: float = -np.inf, high: float = np.inf) -> "Distribution":
        """Return the bell cut off at ``low`` and ``high``."""
        return cls("normal", low=low, high=high, mean=mean, std=std)

    @classmethod
    def choice(cls, *values: float) -> "Distribution":
        """Return the distribution that gives one of ``values``, each as often."""
        return cls("choices", low=min(values), high=max(values), values=values)

    @classmethod
    def from_plain(cls, data: Any, where: str) -> "Distribution":
        """Read a number or one of the mappings of the class's description.

        Raises:
            ConfigError: The keys fit no family or a value is no number.
        """
        if _is_number(data):
            return cls.constant(float(data))
        kind = _kind_of(data, where)
        numbers = {
            key: _numbers(value if key in ("choices", "weights") else [value], f"{where}.{key}")
            for key, value in data.items()
        }
        try:
            if kind == "choices":
                values = numbers["choices"]
                ends = min(values, default=0.0), max(values, default=0.0)
                return cls(kind, *ends, values=values, weights=numbers.get("weights", ()))
            number = {key: values[0] for key, values in numbers.items()}
            low, high = number.get("min", -np.inf), number.get("max", np.inf)
            return cls(kind, low, high, number.get("mean", 0.0), number.get("std", 0.0))
        except ValueError as problem:
            raise ConfigError(f"{where}: {problem}") from problem

    def check_within(self, allowed: Range, name: str) -> None:
        """Reject draws outside of ``allowed``: all that can come must lie in it.

        Raises:
            ValueError: Some lies outside, is not whole where only whole numbers are sampled, or the bell has no end.
        """
        ends = self.values or (self.low, self.high)
        outside = next((end for end in ends if end not in allowed), None)
        if outside is not None:
            hint = "; give it min and max" if self.kind == "normal" else ""
            raise ValueError(f"{name} must stay within {allowed.text}, found {outside:g}{hint}")
        if not self.std <= allowed.high - allowed.low:
            raise ValueError(f"{name} has a std of {self.std:g}, more than its whole range of {allowed.text}")
        broken = next((end for end in ends if allowed.whole and not float(end).is_integer()), None)
        if broken is not None:
            raise ValueError(f"{name} must be a whole number of {allowed.text}, found {broken:g}")

    def to_plain(self) -> Any:
        """Return what ``from_plain`` reads back."""
        if self.kind == "constant":
            return self.low
        if self.kind == "choices":
            return {"choices": list(self.values), **({"weights": list(self.weights)} if self.weights else {})}
        bell = {"mean": self.mean, "std": self.std} if self.kind == "normal" else {}
        limits = {"min": self.low, "max": self.high}
        return bell | {key: value for key, value in limits.items() if np.isfinite(value)}

    def sample(self, rng: np.random.Generator) -> float:
        """Return one value; every family but the constant uses up the stream, the constant leaves it alone."""
        if self.kind == "constant":
            return self.low
        if self.kind == "uniform":
            return float(rng.uniform(self.low, self.high))
        if self.kind == "choices":
            fractions = np.array(self.weights) / sum(self.weights) if self.weights else None
            return float(rng.choice(np.array(self.values), p=fractions))
        return self._sample_bell(rng)

    def _sample_bell(self, rng: np.random.Generator) -> float:
        """Return one value of the cut-off bell by inverting its distribution function: one draw, no retries."""
        if self.std == 0.0:
            return self.mean
        bell, least, most = self._bell
        fraction = rng.uniform(least, most)
        if not 0.0 < fraction < 1.0:  # beyond eight sigma the fraction rounds to 0 or 1
            return self.mean
        return float(min(max(bell.inv_cdf(fraction), self.low), self.high))

    @cached_property
    def _bell(self) -> tuple[NormalDist, float, float]:
        """The bell, and what part of it lies below its lower and its upper end."""
        bell = NormalDist(self.mean, self.std)
        return bell, bell.cdf(self.low), bell.cdf(self.high)

    def sample_count(self, rng: np.random.Generator) -> int:
        """Return one value as a whole number; an even range gives each whole number in it as often."""
        if self.kind == "uniform":
            return int(rng.integers(int(np.ceil(self.low)), int(np.floor(self.high)) + 1))
        return round(self.sample(rng))


def _can_weigh(weights: tuple[float, ...]) -> bool:
    return all(weight in _WEIGHTS for weight in weights) and sum(weights) > 0


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < math.inf


def _kind_of(data: Any, where: str) -> Any:
    keys = set(data) if isinstance(data, dict) else set()
    for kind, (required, optional) in _KEYS.items():
        if required <= keys <= required | optional:
            return kind
    raise ConfigError(
        f"{where} must be a number, {{min, max}}, {{mean, std, min, max}} or {{choices, weights}}, found {shown(data)}"
    )


def _numbers(data: Any, where: str) -> tuple[float, ...]:
    if not isinstance(data, (list, tuple)) or not all(map(_is_number, data)):
        raise ConfigError(f"{where} must hold finite numbers only, found {shown(data)}")
    return tuple(float(value) for value in data)
