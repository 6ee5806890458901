"""What a recipe says of occlusion: how much of the target may be seen, and what may hide the rest."""

from dataclasses import dataclass
from typing import Annotated, Any, Literal, get_args

import numpy as np

from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import ConfigError, shown
from warehouse_sim.ranges import Fraction, Range, ranged

Kind = Literal["border", "load", "pallet", "rack", "traffic", "building", "wrap"]
"""What may hide a target. "wrap" is a load in film; what hides is its goods, so that it is measured as "load"."""
KINDS: tuple[Kind, ...] = get_args(Kind)


@dataclass(frozen=True)
@ranged
class FractionRange:
    """A range that the visible fraction shall lie in; with ``width``, a window of that width somewhere in it."""

    min: Fraction
    """Least visible fraction, 0-1."""
    max: Fraction
    """Largest visible fraction, 0-1."""
    width: Fraction | None = None
    """Width of the window that is sampled evenly within the range for each request, 0-1; None = the whole range."""

    def __post_init__(self) -> None:
        if self.min >= self.max:
            raise ValueError(f"a visible fraction needs min < max, found {self.min} and {self.max}")
        if self.width is not None and not 0.0 < self.width <= self.max - self.min + 1e-9:
            raise ValueError(f"width must be above 0 and at most max - min, found {self.width}")

    def sample(self, rng: np.random.Generator) -> tuple[float, float]:
        """Return least and largest visible fraction of one request."""
        if self.width is None:
            return self.min, self.max
        low = float(rng.uniform(self.min, self.max - self.width))
        return low, low + self.width


@dataclass(frozen=True)
@ranged
class VisibleFractions:
    """The ranges that the observations of a dataset go through in turn; in YAML one mapping or a list of them."""

    ranges: tuple[FractionRange, ...]
    """At least one."""

    def __post_init__(self) -> None:
        if not self.ranges:
            raise ValueError("visible_fraction needs at least one range")

    @classmethod
    def from_plain(cls, data: Any, where: str) -> "VisibleFractions":
        """Read ``{min, max[, width]}`` or a list of such mappings.

        Raises:
            ConfigError: A mapping does not describe a range.
        """
        items = data if isinstance(data, list) else [data]
        if not items or not all(isinstance(item, dict) for item in items):
            raise ConfigError(f"{where}: must be {{min, max}} or a list of them, found {shown(data)}")
        return cls(tuple(from_mapping(FractionRange, item, f"{where}[{i}]") for i, item in enumerate(items)))

    def to_plain(self) -> Any:
        """Return what ``from_plain`` reads back."""
        return [to_mapping(item) for item in self.ranges]


@dataclass(frozen=True)
@ranged
class OcclusionConfig:
    """How much of the target of each observation shall be seen; kept by choice of view and by occluders."""

    visible_fraction: VisibleFractions
    """Visible pixels over all pixels of the unoccluded amodal mask, those outside of the image included."""
    kinds: tuple[Kind, ...] = KINDS
    """What may hide the target most; each request draws which it tries first."""
    tries: Annotated[int, Range(1, 1000)] = 60
    """Views and occluders that are tried for one request at most, 1-1,000; the nearest view found stays then."""
    camera_clearance: Annotated[float, Range(0.3, 5, "m")] = 0.8
    """Least distance from a placed occluder to the camera of any view of the scene (m), 0.3-5."""

    def __post_init__(self) -> None:
        if not self.kinds or len(set(self.kinds)) < len(self.kinds):
            raise ValueError(f"kinds must list each kind at most once and at least one, found {list(self.kinds)}")

    def request(self, number: int, rng: np.random.Generator) -> tuple[float, float]:
        """Return least and largest visible fraction of the dataset's request ``number``."""
        ranges = self.visible_fraction.ranges
        return ranges[number % len(ranges)].sample(rng)
