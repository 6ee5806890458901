"""What every model of a depth camera offers, and how a recipe names one."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, fields
from typing import Annotated, Any, ClassVar, Self

import numpy as np
from jaxtyping import Float32

from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import ConfigError, shown
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors.shot import Shot

Depth = Float32[np.ndarray, "h w"]
_NOTHING = 1e-6
"""Depth that is no reading (m)."""


@dataclass(frozen=True)
@ranged
class DepthModel(ABC):
    """Settings that all models share; a recipe names the model by ``model``, or by ``preset``."""

    kind: ClassVar[str]
    """Value of ``model`` in a recipe."""
    needs_normals: ClassVar[bool] = False
    """Whether ``RenderBuffers.normals`` must be filled."""
    needs_surfaces: ClassVar[bool] = False
    """Whether ``Shot.surfaces`` must be filled."""

    noise_scale: Annotated[float, Range(0, 100)] = 1.0
    """Factor on the standard deviation of the model's random errors, 0-100; without effect on the ideal model."""
    min_range: Annotated[float, Range(0, 500, "m")] = 0.3
    """Nearest depth that is read (m), 0-500."""
    max_range: Annotated[float, Range(0.01, 500, "m")] = 30.0
    """Farthest depth that is read (m), > min_range, 0.01-500."""

    def __post_init__(self) -> None:
        if self.max_range <= self.min_range:
            raise ValueError(f"max_range must exceed min_range {self.min_range}, found {self.max_range}")

    @abstractmethod
    def measure(self, buffers: RenderBuffers, shot: Shot, rng: np.random.Generator) -> Depth:
        """Return the depth that is read (m), 0 = none, before the range limits.

        Args:
            buffers: The clean truth.
            shot: Camera and materials.
            rng: Source of all random errors.
        """

    def read(self, buffers: RenderBuffers, shot: Shot, rng: np.random.Generator) -> Depth:
        """Return the depth that is read (m), 0 = none; what lies or seems to lie out of range is not read.

        Raises:
            ValueError: Normals or materials are missing that the model needs.
        """
        if self.needs_normals and buffers.normals is None:
            raise ValueError(f"the depth model {self.kind!r} needs the normals of the rendering; render with normals")
        if self.needs_surfaces and shot.surfaces is None:
            raise ValueError(f"the depth model {self.kind!r} needs the materials of the pixels; see see_surfaces")
        measured = self.measure(buffers, shot, rng)
        usable = (buffers.depth >= self.min_range) & (buffers.depth <= self.max_range)
        usable &= (measured >= max(self.min_range, _NOTHING)) & (measured <= self.max_range)
        return np.where(usable, measured, np.float32(0.0))

    @classmethod
    def from_plain(cls, data: Any, where: str) -> Self:
        """Read a preset's name, or a mapping with ``model`` or ``preset`` and settings that replace the preset's.

        Raises:
            ConfigError: Unknown model, preset or setting.
        """
        from warehouse_sim.sensors.depth.models import MODELS, PRESETS

        data = {"preset": data} if isinstance(data, str) else data
        if not isinstance(data, dict):
            raise ConfigError(f"{where}: expected a preset's name or a mapping of settings, found {shown(data)}")
        settings = dict(data)
        preset, kind = settings.pop("preset", None), settings.pop("model", None)
        if preset is not None:
            _require_known(preset, PRESETS, f"{where}: preset")
            kind = kind or PRESETS[preset].kind
            settings = to_mapping(PRESETS[preset]) | settings
            if settings.pop("model") != kind:
                raise ConfigError(
                    f"{where}: the preset {preset!r} is of the model {PRESETS[preset].kind!r}, not {kind!r}"
                )
        kind = "quadratic" if kind is None else kind
        _require_known(kind, MODELS, f"{where}: model")
        found = from_mapping(MODELS[kind], settings, where)
        if not isinstance(found, cls):
            raise ConfigError(f"{where}: model must be {cls.kind!r}, found {kind!r}")
        return found

    def to_plain(self) -> dict[str, Any]:
        """Return what ``from_plain`` reads back."""
        return {"model": self.kind} | {item.name: to_mapping(getattr(self, item.name)) for item in fields(self)}


def _require_known(name: Any, known: dict[str, Any], where: str) -> None:
    if not isinstance(name, str) or name not in known:
        raise ConfigError(f"{where} must be one of {', '.join(map(repr, known))}, found {shown(name)}")
