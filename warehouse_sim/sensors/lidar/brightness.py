"""How the intensities that a LiDAR reads of one material differ."""

from dataclasses import dataclass
from typing import Annotated, Any

from warehouse_sim.config import from_mapping
from warehouse_sim.ranges import Range, ranged


@dataclass(frozen=True)
@ranged
class BrightnessConfig:
    """Spread of the intensity, of surfaces and of the sensor; in YAML also ``even``, which is none."""

    grain: Annotated[float, Range(0, 2)] = 0.5
    """Power of the material's albedo texture that scales its remission, 0-2; 0 = no texture."""
    gloss: bool = True
    """Whether smooth and metallic surfaces have a lobe around their normal, and lose light to it beside."""
    object_jitter: Annotated[float, Range(0, 1)] = 0.1
    """Relative standard deviation of the remission of equal objects, and of each material of a scene, 0-1."""
    laser_gain: Annotated[float, Range(0, 1)] = 0.12
    """Relative standard deviation of the gain of each laser of a unit, 0-1."""
    range_residual: Annotated[float, Range(0, 1)] = 0.05
    """Relative standard deviation, over distance, of what a unit's calibration leaves, 0-1."""
    speckle: Annotated[float, Range(0, 1)] = 0.1
    """Relative standard deviation from pulse to pulse, 0-1."""

    @classmethod
    def even(cls) -> "BrightnessConfig":
        """Return none of it: intensity is remission times the cosine of incidence."""
        return cls(grain=0.0, gloss=False, object_jitter=0.0, laser_gain=0.0, range_residual=0.0, speckle=0.0)

    @classmethod
    def from_plain(cls, data: Any, where: str) -> "BrightnessConfig":
        """Read settings, or the word ``even``.

        Raises:
            ConfigError: Unknown setting.
        """
        return cls.even() if data == "even" else from_mapping(cls, data, where)
