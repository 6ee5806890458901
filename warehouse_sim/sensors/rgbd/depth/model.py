"""What every model of a depth camera offers, and depth in a few numbers."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, fields, replace
from typing import Annotated, Any, ClassVar, Self

import numpy as np
from jaxtyping import Float32

from warehouse_sim.config import to_mapping
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors.rgbd.depth.noise import unit_noise
from warehouse_sim.sensors.view import Capture

Depth = Float32[np.ndarray, "h w"]
_UNITS = 1_000_001
_NOTHING = 1e-6
"""Depth that is no reading (m)."""


@dataclass(frozen=True)
@ranged
class DepthModel(ABC):
    """Settings that all models share."""

    kind: ClassVar[str]
    """Value of ``model`` in a recipe."""
    needs_normals: ClassVar[bool] = False
    """Whether ``RenderBuffers.normals`` must be filled."""
    needs_color: ClassVar[bool] = True
    """Whether ``RenderBuffers.rgb`` must be filled."""
    needs_surfaces: ClassVar[bool] = False
    """Whether ``Capture.surfaces`` must be filled."""

    noise_scale: Annotated[float, Range(0, 100)] = 1.0
    """Factor on the standard deviation of the model's random errors, 0-100; without effect on the ideal model."""
    min_range: Annotated[float, Range(0, 500, "m")] = 0.3
    """Nearest depth that is read (m), 0-500."""
    max_range: Annotated[float, Range(0.01, 500, "m")] = 30.0
    """Farthest depth that is read (m), > min_range, 0.01-500."""
    unit: Annotated[int, Range(0, 1_000_000)] | None = None
    """Number of the built camera whose constant errors it has, 0-1,000,000; null = another one each scene, 0 where
    there is no scene. Without effect on models that have no such errors."""

    def __post_init__(self) -> None:
        if self.max_range <= self.min_range:
            raise ValueError(f"max_range must exceed min_range {self.min_range}, found {self.max_range}")

    @property
    def built(self) -> int:
        """Number of the built camera."""
        return self.unit or 0

    def sampled(self, rng: np.random.Generator) -> Self:
        """Return the model with a number for its built camera, if it has none."""
        return self if self.unit is not None else replace(self, unit=int(rng.integers(_UNITS)))

    @property
    def needs_reflections(self) -> bool:
        """Whether ``Surfaces.reflected`` must be filled."""
        return False

    @property
    def sees_film(self) -> bool:
        """Whether ``Capture.film`` is looked at."""
        return False

    @abstractmethod
    def measure(self, buffers: RenderBuffers, capture: Capture, rng: np.random.Generator) -> Depth:
        """Return the depth that is read (m), 0 = none, before the range limits.

        Args:
            buffers: The clean ground truth.
            capture: Camera and materials.
            rng: Source of all random errors.
        """

    def read(self, buffers: RenderBuffers, capture: Capture, rng: np.random.Generator) -> Depth:
        """Return the depth that is read (m), 0 = none; what lies or seems to lie out of range is not read.

        Raises:
            ValueError: Normals or materials are missing that the model needs.
        """
        if self.needs_normals and buffers.normals is None:
            raise ValueError(f"the depth model {self.kind!r} needs the normals of the rendering; render with normals")
        if self.needs_color and not buffers.rgb.size:
            raise ValueError(f"the depth model {self.kind!r} needs the colours of the rendering; render with color")
        if self.needs_surfaces and capture.surfaces is None:
            raise ValueError(f"the depth model {self.kind!r} needs the materials of the pixels; see see_surfaces")
        if self.needs_reflections and (capture.surfaces is None or capture.surfaces.reflected is None):
            raise ValueError(f"the depth model {self.kind!r} follows reflections; see see_surfaces(reflections=True)")
        measured = self.measure(buffers, capture, rng)
        usable = (buffers.depth >= self.min_range) & (buffers.depth <= self.max_range)
        usable &= (measured >= max(self.min_range, _NOTHING)) & (measured <= self.max_range)
        return np.where(usable, measured, np.float32(0.0))

    def to_plain(self) -> dict[str, Any]:
        """Return what ``read_depth_model`` reads back."""
        return {"model": self.kind} | {item.name: to_mapping(getattr(self, item.name)) for item in fields(self)}


@dataclass(frozen=True)
@ranged
class LitDepth(DepthModel):
    """A camera with a light of its own, which meets stretch film."""

    film: bool = True
    """Whether film sends its light back and weakens or blurs what is behind it; else film is not there at all, but for
    the tint that active stereo sees."""

    @property
    def sees_film(self) -> bool:
        """Whether ``Capture.film`` is looked at."""
        return self.film


@dataclass(frozen=True)
class IdealDepth(DepthModel):
    """A camera without errors."""

    kind: ClassVar[str] = "ideal"
    needs_color: ClassVar[bool] = False

    def measure(self, buffers: RenderBuffers, capture: Capture, rng: np.random.Generator) -> Depth:
        """Return the clean depth (m)."""
        return buffers.depth


@dataclass(frozen=True)
@ranged
class QuadraticDepth(DepthModel):
    """Gaussian noise of ``sigma(z) = sigma_base + sigma_quadratic * z^2``, whatever the surface; no holes.

    Triangulation gives ``z = f b / d``, so an error of the disparity ``d`` grows as ``dz = z^2 / (f b) dd``.
    """

    kind: ClassVar[str] = "quadratic"
    needs_color: ClassVar[bool] = False

    sigma_base: Annotated[float, Range(0, 10, "m")] = 0.001
    """Standard deviation of depth that does not grow with distance (m), 0-10."""
    sigma_quadratic: Annotated[float, Range(0, 10, "1/m")] = 0.001
    """Growth of that standard deviation with the square of depth (1/m), 0-10: stereo's z^2 law."""
    correlation_px: ClassVar[int] = 5
    """Edge of the window over which depth noise is alike (px), odd; 1 = each pixel by itself."""

    def measure(self, buffers: RenderBuffers, capture: Capture, rng: np.random.Generator) -> Depth:
        """Return depth with the noise of the formula (m)."""
        depth = result = buffers.depth
        base, quadratic = self.noise_scale * self.sigma_base, self.noise_scale * self.sigma_quadratic
        if base > 0 or quadratic > 0:
            sigma = np.float32(base) + np.float32(quadratic) * depth * depth
            result = depth + sigma * unit_noise((depth.shape[0], depth.shape[1]), rng, self.correlation_px)
        return np.where(depth > 0, np.maximum(result, np.float32(0.0)), np.float32(0.0))
