"""Settings of a recipe's light: where lamps hang, what burns, how bright, and how the camera is exposed."""

from dataclasses import dataclass, replace
from typing import Any

from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.lighting.exposure import ExposureConfig
from warehouse_sim.scene.lighting.presets import PRESETS, Preset, PresetName


@dataclass(frozen=True)
class LightingConfig:
    """Lamps, daylight and exposure. What is null is up to the preset."""

    preset: PresetName = "nominal"
    """Kind of light: nominal, dim, harsh, backlit, night, mixed_colour or failing."""
    rows: int = 1
    """Rows of luminaires along the aisle, 1-3. Like the next two it is geometry, the same under every preset."""
    luminaires: int = 3
    """Luminaires in a row, 1-8."""
    mounting_height: float = 7.0
    """Height of the luminaires above the floor (m), 3-8.5."""
    lux: Distribution | None = None
    """Wanted mean illuminance of the aisle's free floor (lx), > 0; all light is scaled to reach it."""
    flux: Distribution | None = None
    """Luminous flux of a luminaire that burns fully (lm), > 0, instead of ``lux``: then the floor gets what it gets."""
    beam_deg: float | None = None
    """Full angle in which a luminaire has at least half of its intensity (deg), 10-150."""
    temperature: Distribution | None = None
    """Correlated colour temperature of the lamps (K), 1700-20000, the same for all of a scene."""
    ambient_share: float | None = None
    """Illuminance of the even light from above over the mean of the lamps' on the floor, 0-10."""
    headlights: bool | None = None
    """Whether the vehicle drives with its work lights on."""
    white_balance: float | None = None
    """Colour temperature that the camera takes for white (K), 1700-20000."""
    exposure: ExposureConfig | None = None
    """How the camera is exposed."""

    def __post_init__(self) -> None:
        for name, low, high in (("rows", 1, 3), ("luminaires", 1, 8), ("mounting_height", 3.0, 8.5)):
            if not low <= getattr(self, name) <= high:
                raise ValueError(f"{name} must be {low}-{high}, found {getattr(self, name)}")
        if self.lux is not None and self.flux is not None:
            raise ValueError("lux and flux cannot both be given: all light is scaled to lux, or is what flux gives")
        for name in ("lux", "flux"):
            wanted: Distribution | None = getattr(self, name)
            if wanted is not None and wanted.low <= 0.0:
                raise ValueError(f"{name} must stay above 0, found {wanted.low}")
        if self.beam_deg is not None and not 10.0 <= self.beam_deg <= 150.0:
            raise ValueError(f"beam_deg must be 10-150, found {self.beam_deg}")
        if self.ambient_share is not None and not 0.0 <= self.ambient_share <= 10.0:
            raise ValueError(f"ambient_share must be 0-10, found {self.ambient_share}")
        self._check_temperatures()

    def _check_temperatures(self) -> None:
        temperature, white = self.temperature, self.white_balance
        lowest = [] if temperature is None else [temperature.low]
        highest = [] if temperature is None else [temperature.high]
        if min([*lowest, white or 4700.0]) < 1700.0 or max([*highest, white or 4700.0]) > 20000.0:
            raise ValueError("temperature and white_balance must stay within 1700-20000 K")

    def resolved(self) -> Preset:
        """Return the preset with what this recipe says otherwise."""
        preset = PRESETS[self.preset]
        own: dict[str, Any] = {
            "lux": self.lux,
            "beam_deg": self.beam_deg,
            "temperatures": None if self.temperature is None else (self.temperature,),
            "ambient_share": self.ambient_share,
            "headlights": self.headlights,
            "white_balance": self.white_balance,
            "exposure": self.exposure,
        }
        return replace(preset, **{name: value for name, value in own.items() if value is not None})
