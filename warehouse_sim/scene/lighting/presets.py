"""Named kinds of light: which luminaires are on, how, and how the camera is exposed for it."""

from dataclasses import dataclass, field
from typing import Literal

from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.lighting.daylight import Hour
from warehouse_sim.scene.lighting.exposure import ExposureConfig
from warehouse_sim.schema import IntensityDistribution

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
        exposure=ExposureConfig(min_ev=4.6),
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
