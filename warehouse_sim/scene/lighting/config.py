"""Settings of a recipe's light: where luminaires hang, which are on, how bright, how the camera is exposed; presets."""

from dataclasses import dataclass, field, replace
from typing import Annotated, Any, Literal

from warehouse_sim.errors import ConfigError, UnknownNameError
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.resources import find_photometry
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.lighting.exposure import ExposureConfig
from warehouse_sim.scene.lighting.ies_file import load_distribution
from warehouse_sim.schema import IntensityDistribution

Hour = Literal["day", "dusk", "night"]
PresetName = Literal["nominal", "dim", "harsh", "backlit", "night", "mixed_colour", "failing"]


@dataclass(frozen=True)
class Preset:
    """What a kind of light means where a recipe does not say otherwise."""

    lux: Distribution
    """Mean illuminance of the aisle's free floor (lx)."""
    temperatures: tuple[Distribution, ...] = (Distribution.uniform(4000.0, 5200.0),)
    """Colour temperature of luminaires (K), sampled once a scene: of one row after the other, or in parts of one
    row."""
    beam_deg: float = 110.0
    """Full angle of half intensity (deg)."""
    distribution: IntensityDistribution | None = None
    """What the recipe's photometric file says in its place."""
    tilt_deg: float = 0.0
    """Angle of the luminaires' axes from straight down, to the one end of the aisle and the other in turn (deg)."""
    pattern: tuple[float, ...] = (1.0,)
    """Flux of one luminaire after the other, as fraction of the full one; repeated along each row."""
    failed_fraction: float = 0.0
    """Fraction of the luminaires that are dark, others in each scene, 0-1; one more gives a quarter of its flux."""
    source_radius: float = 0.15
    """Radius of the source of light in a luminaire (m)."""
    ambient_fraction: float = 0.12
    """Illuminance of the even light from above over the mean of the luminaires' on the floor."""
    sky_luminance: float = 0.0
    """Of what is seen through the open doors (cd/m^2), before all light is scaled to the wanted lux; 0 = shut."""
    hour: Hour = "day"
    """Of what is seen outside, through windows and openings: day, dusk or night."""
    headlights: bool = False
    """Whether the vehicle drives with its work lights on."""
    white_balance: float = 4700.0
    """Colour temperature that the camera takes for white (K)."""
    exposure: ExposureConfig = field(default_factory=ExposureConfig)
    """How the camera is exposed."""


PRESETS: dict[PresetName, Preset] = {
    # EN 12464-1 requires 200 lx where people work in a store and 300 lx where they read labels.
    "nominal": Preset(lux=Distribution.uniform(200.0, 300.0)),
    "dim": Preset(
        lux=Distribution.uniform(20.0, 50.0),
        temperatures=(Distribution.uniform(3500.0, 4300.0),),
        pattern=(1.0, 0.0),
        ambient_fraction=0.06,
        hour="dusk",
        exposure=ExposureConfig(min_ev=2.6),
    ),
    "harsh": Preset(
        lux=Distribution.uniform(150.0, 350.0),
        temperatures=(Distribution.uniform(5000.0, 5800.0),),
        beam_deg=70.0,
        tilt_deg=35.0,
        pattern=(1.0, 0.0, 0.0),
        source_radius=0.02,
        ambient_fraction=0.015,
        exposure=ExposureConfig(compensation=-0.5),
    ),
    "backlit": Preset(
        lux=Distribution.uniform(60.0, 150.0),
        pattern=(0.0, 0.1),
        ambient_fraction=0.05,
        sky_luminance=6000.0,
        white_balance=5200.0,
        exposure=ExposureConfig(compensation=-0.3),
    ),
    # EN 1838 requires 1 lx along escape routes.
    "night": Preset(
        lux=Distribution.uniform(0.5, 2.0),
        pattern=(1.0, 0.0, 0.0),
        ambient_fraction=0.05,
        hour="night",
        headlights=True,
        white_balance=5000.0,
        exposure=ExposureConfig(min_ev=4.2),
    ),
    "mixed_colour": Preset(
        lux=Distribution.uniform(150.0, 250.0),
        temperatures=(Distribution.uniform(2700.0, 2900.0), Distribution.uniform(6200.0, 6500.0)),
        beam_deg=80.0,
        ambient_fraction=0.05,
        hour="dusk",
        white_balance=4000.0,
    ),
    "failing": Preset(
        lux=Distribution.uniform(60.0, 140.0),
        beam_deg=80.0,
        failed_fraction=0.45,
        ambient_fraction=0.03,
        hour="night",
        exposure=ExposureConfig(compensation=-0.8),
    ),
}
"""Value of ``lights.preset`` in a recipe -> what it means."""


FORMULA = "formula"
"""Value of ``photometry`` that names no file."""
LuminaireName = Literal["highbay", "round", "trunking"]


@dataclass(frozen=True)
@ranged
class LightingConfig:
    """Luminaires, daylight and exposure. What is null is up to the preset."""

    preset: PresetName = "nominal"
    """Kind of light: nominal, dim, harsh, backlit, night, mixed_colour or failing."""
    rows: Annotated[int, Range(1, 3)] = 1
    """Rows of luminaires along the aisle, 1-3. Like the next two it is geometry, the same under every preset."""
    luminaires: Annotated[int, Range(1, 8)] = 3
    """Luminaires in a row, 1-8."""
    mounting_height: Annotated[float, Range(2.4, 13.8, "m")] | None = 7.0
    """Height of the luminaires above the floor (m), 2.4-13.8; null for right under the hall's girders."""
    luminaire: LuminaireName = "highbay"
    """What hangs there: linear high-bay luminaires, round ones, or rows of trunking: highbay, round or trunking."""
    hall_fraction: Annotated[float, Range(0, 3)] = 0.0
    """How bright rows of light beside the aisle (``hall.services.light_lines``) make the hall's floor, over the aisle's
    from its own luminaires, 0-3, where all are on; a preset's pattern darkens rows, too. At 0 they only glow."""
    daylight: bool = False
    """Whether rooflights and windows (``hall.services``) light the hall by day and at dusk; else they only glow."""
    lux: Annotated[Distribution, Range(0.001, 200_000, "lx")] | None = None
    """Wanted mean illuminance of the aisle's free floor (lx), 0.001-200,000; all light is scaled to reach it."""
    flux: Annotated[Distribution, Range(1, 10_000_000, "lm")] | None = None
    """Luminous flux of a luminaire that is fully on (lm), 1-10,000,000, instead of ``lux``, which then follows."""
    beam_deg: Annotated[float, Range(10, 150, "deg")] | None = None
    """Full angle in which a luminaire has at least half of its intensity (deg), 10-150."""
    photometry: str = FORMULA
    """How luminaires spread their light: ``formula`` (by ``beam_deg``), a shipped file's name, ``aisle_narrow`` or
    ``highbay_wide``, or the path of an IES file (LM-63)."""
    photometry_flux: bool = False
    """Whether luminaires give the lumens of that file, instead of what ``lux`` requires."""
    temperature: Annotated[Distribution, Range(1700, 20_000, "K")] | None = None
    """Correlated colour temperature of the luminaires (K), 1,700-20,000, the same for all of a scene."""
    ambient_fraction: Annotated[float, Range(0, 10)] | None = None
    """Illuminance of the even light from above over the mean of the luminaires' on the floor, 0-10."""
    headlights: bool | None = None
    """Whether the vehicle drives with its work lights on."""
    white_balance: Annotated[float, Range(1700, 20_000, "K")] | None = None
    """Colour temperature that the camera takes for white (K), 1,700-20,000."""
    exposure: ExposureConfig | None = None
    """How the camera is exposed."""
    compensation: Annotated[float, Range(-3, 3, "stops")] = 0.0
    """Stops by which metered images are brighter than the preset or ``exposure`` says, -3 to 3."""
    exposure_lag: Annotated[float, Range(0, 60, "s")] = 0.0
    """Time constant (s) with which metered exposure follows the view within a drive, 0-60. No source: a prior."""

    def __post_init__(self) -> None:
        if self.lux is not None and self.flux is not None:
            raise ValueError("lux and flux cannot both be given: all light is scaled to lux, or is what flux gives")
        if self.photometry != FORMULA and self.beam_deg is not None:
            raise ValueError("photometry and beam_deg cannot both be given: the file says how wide the light is")
        if self.photometry_flux and (self.photometry == FORMULA or self.lux is not None or self.flux is not None):
            raise ValueError("photometry_flux needs photometry, and neither lux nor flux")
        self.resolved()  # both compensations together must be within the range of one

    def resolved(self) -> Preset:
        """Return the preset with what this recipe says otherwise."""
        preset = PRESETS[self.preset]
        alike = ("lux", "beam_deg", "ambient_fraction", "headlights", "white_balance", "exposure")
        own: dict[str, Any] = {name: getattr(self, name) for name in alike} | {
            "distribution": self._distribution(),
            "temperatures": None if self.temperature is None else (self.temperature,),
        }
        preset = replace(preset, **{name: value for name, value in own.items() if value is not None})
        stops = preset.exposure.compensation + self.compensation
        return replace(preset, exposure=replace(preset.exposure, compensation=stops)) if self.compensation else preset

    def _distribution(self) -> IntensityDistribution | None:
        if self.photometry == FORMULA:
            return None
        try:
            return load_distribution(find_photometry(self.photometry))
        except UnknownNameError as problem:
            raise ConfigError(f"photometry: {problem}") from problem
